//! The one table of makers: it drives parsing, properties, errors and the reference.
//!
//! A new noun is one [`Form`] here (or in `nouns`) and its name in [`FORMS`].

use crate::handle::Handle;
use crate::vec3::Vec3;
use glam::DVec3;
use reflet_scene::{Fault, Key, MeshData, Noun, Program, Scene, Surface, Texture, Tiles, Worn};
use rhai::Dynamic;
use std::sync::Arc;

/// What the value of a key is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Takes {
    /// A place: a finite vector.
    Point,
    /// A vector of any length but zero.
    Direction,
    /// A finite vector, or one number for grey.
    Colour,
    /// Degrees about three axes.
    Angles,
    /// A finite number other than 0.
    Factor,
    /// A finite number above 0.
    Positive,
    /// A finite number, 0 or more.
    NotNegative,
    /// A number of degrees above 0 and below this.
    Degrees(f64),
    /// A whole number in this range.
    Whole(u32, u32),
    /// Two finite numbers above 0.
    Sizes,
    /// Two or three finite numbers above 0.
    TileSizes,
    /// Three finite numbers above 0.
    Lengths,
    /// A finite number other than 0, or three of them.
    Scale,
    /// One of these strings.
    Word(&'static [&'static str]),
    /// `true` or `false`.
    Flag,
    /// A material, a pattern, or a material's map.
    Wear,
    /// A material or its map.
    Paint,
    /// Materials by the names that a mesh file gives them.
    Wardrobe,
    /// The name of a mesh file.
    File,
    /// The name of a picture file.
    Image,
    /// A shader function.
    Expression,
}

impl Takes {
    /// In words, to follow "takes".
    pub fn words(self) -> String {
        match self {
            Takes::Point => "a vector [x, y, z] or vec3".into(),
            Takes::Direction => "a direction [x, y, z] or vec3, other than zero".into(),
            Takes::Colour => "a colour [r, g, b] or vec3, or one number for grey".into(),
            Takes::Angles => "degrees about [x, y, z]".into(),
            Takes::Factor => "a number other than 0".into(),
            Takes::Positive => "a number above 0".into(),
            Takes::NotNegative => "a number, 0 or more".into(),
            Takes::Degrees(below) => format!("degrees above 0 and below {below}"),
            Takes::Whole(low, high) => format!("a whole number from {low} to {high}"),
            Takes::Sizes => "two numbers above 0, [x, y]".into(),
            Takes::TileSizes => "two or three numbers above 0, [x, y] or [x, y, z]".into(),
            Takes::Lengths => "three numbers above 0, [x, y, z] or vec3".into(),
            Takes::Scale => "a number other than 0, or [x, y, z] of such".into(),
            Takes::Word(words) => {
                let quoted: Vec<String> = words.iter().map(|w| format!("\"{w}\"")).collect();
                quoted.join(" or ")
            }
            Takes::Flag => "true or false".into(),
            Takes::Wear => "a material, a pattern, or a map #{...} of a material's keys".into(),
            Takes::Paint => "a material, or a map #{...} of a material's keys".into(),
            Takes::Wardrobe => {
                "a map #{ NAME: material, ... }, with names of the file's materials".into()
            }
            Takes::Image => "the name of a picture file (PNG, JPEG, EXR, HDR, TIFF, WebP, BMP, TGA, QOI, PNM or PFM), a string".into(),
            Takes::Expression => "a function of the hit point, |p| ..., or a colour".into(),
            Takes::File => "the name of a mesh file, a string".into(),
        }
    }
}

/// A value that was found fit for a key.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Number(f64),
    Whole(u32),
    Vector(DVec3),
    Pair([f64; 2]),
    Tiles(Tiles),
    Word(usize),
    Flag(bool),
    Wear(Option<Key>),
    Wardrobe(Vec<Worn>),
    Mesh(Arc<MeshData>),
    Image(Arc<Texture>),
    Expression(Option<Arc<Program>>),
}

macro_rules! taker {
    ($name:ident, $variant:ident, $to:ty) => {
        impl From<Value> for $to {
            fn from(value: Value) -> $to {
                match value {
                    Value::$variant(x) => x,
                    other => unreachable!("the table promised another value than {other:?}"),
                }
            }
        }
        impl From<$to> for Value {
            fn from(x: $to) -> Value {
                Value::$variant(x)
            }
        }
    };
}
taker!(number, Number, f64);
taker!(whole, Whole, u32);
taker!(vector, Vector, DVec3);
taker!(pair, Pair, [f64; 2]);
taker!(tiles, Tiles, Tiles);
taker!(word, Word, usize);
taker!(flag, Flag, bool);
taker!(wear, Wear, Option<Key>);
taker!(wardrobe, Wardrobe, Vec<Worn>);
taker!(mesh, Mesh, Arc<MeshData>);
taker!(image, Image, Arc<Texture>);
taker!(expression, Expression, Option<Arc<Program>>);

/// One key of a maker, which is also a property of its handle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeyInfo {
    pub name: &'static str,
    pub takes: Takes,
    /// What it is if it is not given, as a script writes it; `None`: it must be given.
    pub default: Option<&'static str>,
    pub doc: &'static str,
}

/// A key with its way into a noun and out of it.
pub(crate) struct Field<N> {
    pub info: KeyInfo,
    pub get: fn(&N) -> Value,
    pub set: fn(&mut N, Value),
}

/// What a noun is to the rest of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// It has a place, and wears a material.
    Surface,
    /// It is worn.
    Material,
    /// It is worn, and has a geometry of its own.
    Pattern,
    /// It moves surfaces.
    Group,
    /// It shows surfaces once more.
    Instance,
    Light,
    /// There is one in a scene.
    Camera,
    /// There is one in a scene.
    Image,
    /// There is one in a scene.
    Settings,
    /// There is one in a scene.
    Animation,
}

/// Whether a noun is one that can be rendered.
pub(crate) type Check<N> = fn(&N) -> Result<(), Fault>;

/// One maker, or one of its forms: its keys, and the noun that they fill.
pub(crate) struct Form<N: 'static> {
    pub maker: &'static str,
    pub role: Role,
    pub doc: &'static str,
    /// The noun before any key is written: the defaults, and anything for what must be given.
    pub blank: fn() -> N,
    pub fields: &'static [Field<N>],
    /// What must hold between several keys.
    pub relations: Option<Check<N>>,
    /// The normal of a flat surface, of any length.
    pub normal: Option<fn(&N) -> DVec3>,
}

/// A [`Form`] of any noun.
pub(crate) trait AnyForm: Sync {
    fn maker(&self) -> &'static str;
    fn role(&self) -> Role;
    fn doc(&self) -> &'static str;
    /// The noun's own keys and, of a surface, what all surfaces have.
    fn keys(&self) -> Vec<&'static KeyInfo>;
    /// The key of this name and its place in `keys`.
    fn find(&self, name: &str) -> Option<(usize, &'static KeyInfo)>;
    /// Whether several keys are related.
    fn related(&self) -> bool;
    /// Whether the surface is flat.
    fn flat(&self) -> bool;
    /// Makes an entity of the given values: pairs of a place in `keys` and a value.
    fn make(&self, scene: &mut Scene, values: Vec<(usize, Value)>) -> Result<Key, Fault>;
    /// The value of the key at a place in `keys`.
    fn get(&self, scene: &Scene, key: Key, at: usize) -> Option<Value>;
    /// Writes the value of the key at a place in `keys`.
    fn set(&self, scene: &mut Scene, key: Key, at: usize, value: Value);
    /// What is wrong between the keys.
    fn check(&self, scene: &Scene, key: Key) -> Result<(), Fault>;
    /// The normal of a flat surface.
    fn normal(&self, scene: &Scene, key: Key) -> Option<DVec3>;
}

static SURFACE: [Field<Surface>; 2] = [
    Field {
        info: KeyInfo {
            name: "material",
            takes: Takes::Wear,
            default: Some("a grey matt one"),
            doc: "what it wears",
        },
        get: |s| s.material.into(),
        set: |s, v| s.material = v.into(),
    },
    Field {
        info: KeyInfo {
            name: "visible",
            takes: Takes::Flag,
            default: Some("true"),
            doc: "whether it is in the picture at all",
        },
        get: |s| s.visible.into(),
        set: |s, v| s.visible = v.into(),
    },
];

impl<N: Noun> Form<N> {
    /// The noun of the given values, and what it has as a surface.
    pub fn fill(&self, values: Vec<(usize, Value)>) -> Result<(N, Surface), Fault> {
        let mut noun = (self.blank)();
        let mut surface = Surface { material: None, visible: true };
        for (at, value) in values {
            match self.fields.get(at) {
                Some(field) => (field.set)(&mut noun, value),
                None => (SURFACE[at - self.fields.len()].set)(&mut surface, value),
            }
        }
        if let Some(check) = self.relations {
            check(&noun)?;
        }
        Ok((noun, surface))
    }
}

impl<N: Noun> AnyForm for Form<N> {
    fn maker(&self) -> &'static str {
        self.maker
    }

    fn role(&self) -> Role {
        self.role
    }

    fn doc(&self) -> &'static str {
        self.doc
    }

    fn keys(&self) -> Vec<&'static KeyInfo> {
        let mut keys: Vec<&KeyInfo> = self.fields.iter().map(|f| &f.info).collect();
        if self.role == Role::Surface {
            keys.extend(SURFACE.iter().map(|f| &f.info));
        }
        keys
    }

    fn find(&self, name: &str) -> Option<(usize, &'static KeyInfo)> {
        if let Some(at) = self.fields.iter().position(|f| f.info.name == name) {
            return Some((at, &self.fields[at].info));
        }
        if self.role == Role::Surface {
            let at = SURFACE.iter().position(|f| f.info.name == name)?;
            return Some((self.fields.len() + at, &SURFACE[at].info));
        }
        None
    }

    fn related(&self) -> bool {
        self.relations.is_some()
    }

    fn flat(&self) -> bool {
        self.normal.is_some()
    }

    fn make(&self, scene: &mut Scene, values: Vec<(usize, Value)>) -> Result<Key, Fault> {
        let (noun, surface) = self.fill(values)?;
        Ok(match self.role {
            Role::Surface => scene.spawn((noun, surface)),
            _ => scene.spawn((noun,)),
        })
    }

    fn get(&self, scene: &Scene, key: Key, at: usize) -> Option<Value> {
        match self.fields.get(at) {
            Some(field) => scene.get::<N>(key).map(|noun| (field.get)(&noun)),
            None => scene.get::<Surface>(key).map(|s| (SURFACE[at - self.fields.len()].get)(&s)),
        }
    }

    fn set(&self, scene: &mut Scene, key: Key, at: usize, value: Value) {
        match self.fields.get(at) {
            Some(field) => {
                if let Some(mut noun) = scene.get::<N>(key) {
                    (field.set)(&mut noun, value);
                    scene.set(key, noun);
                }
            }
            None => {
                if let Some(mut surface) = scene.get::<Surface>(key) {
                    let before = surface;
                    (SURFACE[at - self.fields.len()].set)(&mut surface, value);
                    // `ball.material.diffuse = 1` writes the same material back.
                    if before != surface {
                        scene.set(key, surface);
                    }
                }
            }
        }
    }

    fn check(&self, scene: &Scene, key: Key) -> Result<(), Fault> {
        match (self.relations, scene.get::<N>(key)) {
            (Some(check), Some(noun)) => check(&noun),
            _ => Ok(()),
        }
    }

    fn normal(&self, scene: &Scene, key: Key) -> Option<DVec3> {
        let normal = self.normal?;
        scene.get::<N>(key).map(|noun| normal(&noun))
    }
}

/// Which form a handle is of.
#[derive(Clone, Copy)]
pub(crate) struct Kind(pub &'static dyn AnyForm);

impl Kind {
    /// The maker's name.
    pub fn name(self) -> &'static str {
        self.0.maker()
    }

    /// `a sphere`, `an image`, `the settings`.
    pub fn with_article(self) -> String {
        match self.name() {
            "settings" => "the settings".into(),
            "stripes" => "stripes".into(),
            name if name.starts_with(['a', 'e', 'i', 'o', 'u']) => format!("an {name}"),
            name => format!("a {name}"),
        }
    }

    /// Whether two kinds are of the same maker.
    pub fn same(self, other: Kind) -> bool {
        self.name() == other.name()
    }
}

impl PartialEq for Kind {
    fn eq(&self, other: &Kind) -> bool {
        self.same(*other)
    }
}

impl std::fmt::Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

fn numbers(numbers: &[f64]) -> Dynamic {
    Dynamic::from_array(numbers.iter().map(|x| Dynamic::from(*x)).collect())
}

/// What a script reads from a property.
pub(crate) fn to_dynamic(
    value: Value,
    takes: Takes,
    handle: impl Fn(Key) -> Handle,
    file: impl Fn(usize) -> String,
) -> Dynamic {
    match value {
        Value::Number(x) => x.into(),
        Value::Whole(n) => i64::from(n).into(),
        Value::Vector(v) => Dynamic::from(Vec3(v)),
        Value::Pair(size) => numbers(&size),
        Value::Tiles(Tiles::Flat(size)) => numbers(&size),
        Value::Tiles(Tiles::Solid(size)) => numbers(&size),
        Value::Word(at) => match takes {
            Takes::Word(words) => words[at].into(),
            _ => Dynamic::UNIT,
        },
        Value::Flag(flag) => flag.into(),
        Value::Wear(Some(key)) => Dynamic::from(handle(key)),
        Value::Wear(None) => Dynamic::UNIT,
        Value::Mesh(data) => file(Arc::as_ptr(&data) as usize).into(),
        Value::Image(image) => file(Arc::as_ptr(&image) as usize).into(),
        Value::Wardrobe(_) | Value::Expression(_) => Dynamic::UNIT,
    }
}
