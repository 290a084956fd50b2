//! Whole scripts drawn at random: every maker, and edits of nearly every key in frames.
//!
//! A script has a pool of statements that frames may run, and each frame runs some of them. Every
//! frame starts from the scene that the script left, so a statement that runs in frames 1 and 3 is
//! an edit forth, back and forth again.

use std::fmt::Write;

/// A generator of numbers: the same scripts on every machine.
pub struct Dice(pub u64);

impl Dice {
    /// A number in [0, 1).
    pub fn float(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    /// A whole number in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.float() * n as f64) as usize
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of them.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    fn range(&mut self, a: f64, b: f64) -> String {
        format!("{:.3}", a + (b - a) * self.float())
    }

    fn point(&mut self, r: f64) -> String {
        let [x, y, z] = [0; 3].map(|_| self.range(-r, r));
        format!("[{x}, {y}, {z}]")
    }

    /// A direction that is never zero nor along z.
    fn axis(&mut self) -> String {
        let [x, z] = [0; 2].map(|_| self.range(-0.8, 0.8));
        format!("[{x}, 1, {z}]")
    }

    /// A colour; often 0 in some or all of its parts.
    fn colour(&mut self) -> String {
        match self.below(5) {
            0 => "0".into(),
            1 => self.range(0.0, 1.0),
            2 => format!("[0, {}, 0]", self.range(0.1, 1.0)),
            _ => {
                let [r, g, b] = [0; 3].map(|_| self.range(0.0, 1.0));
                format!("[{r}, {g}, {b}]")
            }
        }
    }

    fn material(&mut self) -> String {
        let (ambient, diffuse, specular) = (self.colour(), self.colour(), self.colour());
        format!("#{{ ambient: {ambient}, diffuse: {diffuse}, specular: {specular} }}")
    }
}

/// What a script's name stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    Material,
    /// A pattern that flat surfaces alone can wear.
    Tiles,
    Checker,
    Stripes,
    Textured,
    Shader,
    Surface(Shape),
    Group,
    Instance,
    Light,
    Spotlight,
    Sun,
    Projector,
}

/// A surface's maker.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shape {
    Sphere,
    Plane,
    Quad,
    Triangle,
    Disc,
    CuboidMinMax,
    Cuboid,
    Cylinder,
    Cone,
    Paraboloid,
    Hyperboloid,
    Ellipsoid,
    Torus,
    Mesh,
}

const SHAPES: [Shape; 14] = [
    Shape::Sphere,
    Shape::Plane,
    Shape::Quad,
    Shape::Triangle,
    Shape::Disc,
    Shape::CuboidMinMax,
    Shape::Cuboid,
    Shape::Cylinder,
    Shape::Cone,
    Shape::Paraboloid,
    Shape::Hyperboloid,
    Shape::Ellipsoid,
    Shape::Torus,
    Shape::Mesh,
];

impl Shape {
    fn is_flat(self) -> bool {
        matches!(self, Shape::Plane | Shape::Quad | Shape::Triangle | Shape::Disc)
    }
}

/// A random script.
pub struct Script {
    pub text: String,
    pub frames: u32,
}

/// Names that a script has so far, and how many it has had.
#[derive(Clone, Default)]
struct Names {
    all: Vec<(String, Kind)>,
    made: usize,
    /// Things that are in a group: none goes into another one.
    grouped: Vec<String>,
}

impl Names {
    fn add(&mut self, kind: Kind) -> String {
        let name = format!("x{}", self.made);
        self.made += 1;
        self.all.push((name.clone(), kind));
        name
    }

    fn some(&self, dice: &mut Dice, wanted: impl Fn(Kind) -> bool) -> Option<(String, Kind)> {
        let fitting: Vec<_> = self.all.iter().filter(|(_, kind)| wanted(*kind)).collect();
        (!fitting.is_empty()).then(|| fitting[dice.below(fitting.len())].clone())
    }

    /// Something that a surface can wear: by name, or made in place.
    fn worn(&self, dice: &mut Dice, shape: Option<Shape>) -> String {
        let fits = |kind: Kind| match kind {
            Kind::Material | Kind::Stripes | Kind::Checker | Kind::Shader => true,
            Kind::Tiles => shape.is_some_and(Shape::is_flat),
            Kind::Textured => shape.is_some_and(|s| !matches!(s, Shape::Plane | Shape::Mesh)),
            _ => false,
        };
        match self.some(dice, fits) {
            Some((name, _)) if !dice.once_in(5) => name,
            _ => dice.material(),
        }
    }

    fn plain(&self, dice: &mut Dice) -> String {
        match self.some(dice, |kind| kind == Kind::Material) {
            Some((name, _)) if !dice.once_in(3) => name,
            _ => dice.material(),
        }
    }
}

const PICTURES: [&str; 2] = ["a.ppm", "b.ppm"];
const MESHES: [&str; 3] = ["a.obj", "b.obj", "c.obj"];

/// Draws a script of some frames.
pub fn script(dice: &mut Dice) -> Script {
    let mut names = Names::default();
    let mut text = String::new();
    let frames = 6 + dice.below(4) as u32;
    let (width, height) = (5 + dice.below(44), 5 + dice.below(30));
    let samples = dice.pick(&[1, 1, 1, 2, 3, 4, 5]);
    let _ = writeln!(
        text,
        "let picture = image(#{{ width: {width}, height: {height}, samples: {samples}, adaptive: {}, filter: \"{}\" }});",
        dice.once_in(2),
        dice.pick(&["box", "box", "tent", "gaussian"])
    );
    let _ = writeln!(text, "animation(#{{ frames: {frames} }});");
    let view = dice.below(6);
    let _ = writeln!(
        text,
        "let eye = camera(#{{ {} }});",
        match view {
            0 => "eye: [0.3, 1.5, 6], look_at: [0, 0, 0], ortho: 5",
            1 => "viewpoint: [0.2, 0.3, 6], window: [5, 4]",
            _ => "eye: [0.3, 1.5, 6], look_at: [0, 0, 0], fov: 50",
        }
    );
    let max_path = if dice.once_in(4) { ", max_path: 14" } else { "" };
    let _ = writeln!(
        text,
        "let rules = settings(#{{ max_bounces: {}, background: {}, attenuation: \"{}\"{max_path} }});",
        dice.pick(&[0, 1, 2, 3, 3, 5]),
        dice.colour(),
        dice.pick(&["inverse", "inverse", "none"]),
    );
    for _ in 0..2 + dice.below(3) {
        make(dice, &mut names, &mut text, Kind::Material);
    }
    for kind in [Kind::Tiles, Kind::Checker, Kind::Stripes, Kind::Textured, Kind::Shader] {
        if dice.once_in(3) {
            make(dice, &mut names, &mut text, kind);
        }
    }
    for kind in [Kind::Light, Kind::Spotlight, Kind::Sun, Kind::Projector] {
        if dice.once_in(2) {
            make(dice, &mut names, &mut text, kind);
        }
    }
    for _ in 0..1 + dice.below(6) {
        let shape = surface(dice);
        make(dice, &mut names, &mut text, shape);
    }
    for kind in [Kind::Group, Kind::Instance, Kind::Group, Kind::Instance] {
        if dice.once_in(2) {
            make(dice, &mut names, &mut text, kind);
        }
    }

    let pool: Vec<String> = (0..2 + dice.below(6)).map(|_| edit(dice, &names, view)).collect();
    let _ = writeln!(text, "on_frame(|f| {{");
    for frame in 0..frames {
        let mut names = names.clone();
        // What the script made cannot join a group in a frame.
        names.grouped = names.all.iter().map(|(name, _)| name.clone()).collect();
        let mut body = String::new();
        for statement in &pool {
            if dice.once_in(3) {
                let _ = write!(body, " {statement}");
            }
        }
        for _ in 0..dice.below(3) {
            if dice.once_in(2) {
                let kind = made_in_frame(dice);
                make(dice, &mut names, &mut body, kind);
            } else {
                let _ = write!(body, " {}", edit(dice, &names, view));
            }
        }
        let _ = writeln!(text, "if f.index == {frame} {{{body} }}");
    }
    let _ = writeln!(text, "}});");
    Script { text, frames }
}

fn surface(dice: &mut Dice) -> Kind {
    Kind::Surface(if dice.once_in(3) { Shape::Sphere } else { dice.pick(&SHAPES) })
}

fn made_in_frame(dice: &mut Dice) -> Kind {
    let kinds = [
        Kind::Material,
        Kind::Tiles,
        Kind::Checker,
        Kind::Stripes,
        Kind::Textured,
        Kind::Shader,
        Kind::Group,
        Kind::Instance,
        Kind::Instance,
        Kind::Light,
        Kind::Spotlight,
        Kind::Sun,
        Kind::Projector,
    ];
    if dice.once_in(2) { surface(dice) } else { dice.pick(&kinds) }
}

/// Writes the statement that makes something.
fn make(dice: &mut Dice, names: &mut Names, text: &mut String, kind: Kind) {
    let call = match kind {
        Kind::Material => format!("material({})", dice.material()),
        Kind::Tiles => {
            let (even, odd, xdir) = (names.plain(dice), names.plain(dice), dice.axis());
            let (a, b) = (dice.range(0.3, 1.2), dice.range(0.3, 1.2));
            let xdir = if dice.once_in(2) { String::new() } else { format!(", xdir: {xdir}") };
            // A direction that may be along no flat surface's normal is kept to that of x.
            let xdir = if xdir.is_empty() { xdir } else { ", xdir: [1, 0.2, 0.3]".into() };
            format!("checker(#{{ even: {even}, odd: {odd}, size: [{a}, {b}]{xdir} }})")
        }
        Kind::Checker => {
            let (even, odd) = (names.plain(dice), names.plain(dice));
            let [a, b, c] = [0; 3].map(|_| dice.range(0.2, 0.8));
            format!("checker(#{{ even: {even}, odd: {odd}, size: [{a}, {b}, {c}] }})")
        }
        Kind::Stripes => {
            let (even, odd, width) = (names.plain(dice), names.plain(dice), dice.range(0.1, 0.6));
            format!("stripes(#{{ even: {even}, odd: {odd}, width: {width}, xdir: [1, 0.5, 0.2] }})")
        }
        Kind::Textured => {
            let (base, file) = (names.plain(dice), dice.pick(&PICTURES));
            let filter = dice.pick(&["bilinear", "nearest"]);
            format!("textured(#{{ base: {base}, file: \"{file}\", filter: \"{filter}\" }})")
        }
        Kind::Shader => {
            let (base, key) = (names.plain(dice), dice.pick(&["ambient", "diffuse", "specular"]));
            format!("shader(#{{ base: {base}, {key}: {} }})", function(dice))
        }
        Kind::Surface(shape) => made_surface(dice, names, shape),
        Kind::Group => {
            let free = |name: &String| !names.grouped.contains(name);
            let members: Vec<String> = (0..1 + dice.below(2))
                .filter_map(|_| {
                    let some = |k| matches!(k, Kind::Surface(_) | Kind::Group | Kind::Instance);
                    names.some(dice, some).map(|(name, _)| name).filter(free)
                })
                .collect();
            let mut members = members;
            members.sort();
            members.dedup();
            if members.is_empty() {
                return;
            }
            names.grouped.extend(members.iter().cloned());
            format!("group([{}], {})", members.join(", "), place(dice))
        }
        Kind::Instance => {
            let some = |k| matches!(k, Kind::Surface(_) | Kind::Group | Kind::Instance);
            let Some((of, _)) = names.some(dice, some) else { return };
            format!("instance({of}, {})", place(dice))
        }
        Kind::Light => {
            let (at, emissivity) = (dice.point(4.0), dice.range(0.0, 20.0));
            let falloff = dice.pick(&["inverse", "none", "square"]);
            format!("light(#{{ at: {at}, emissivity: {emissivity}, falloff: \"{falloff}\" }})")
        }
        Kind::Spotlight => {
            let (angle, emissivity) = (dice.range(5.0, 60.0), dice.range(0.0, 30.0));
            format!(
                "spotlight(#{{ at: [0.5, 6, 1], aim: {}, angle: {angle}, emissivity: {emissivity} }})",
                dice.point(1.0)
            )
        }
        Kind::Sun => {
            let (x, z, emissivity) = (dice.range(-1.0, 1.0), dice.range(-1.0, 1.0), dice.colour());
            format!("sun(#{{ direction: [{x}, -1, {z}], emissivity: {emissivity} }})")
        }
        Kind::Projector => {
            let (file, aim) = (dice.pick(&PICTURES), dice.point(1.0));
            format!(
                "projector(#{{ at: [0.5, 3, 5], aim: {aim}, angle: {}, file: \"{file}\", emissivity: {} }})",
                dice.range(10.0, 40.0),
                dice.range(0.0, 20.0)
            )
        }
    };
    let name = names.add(kind);
    let _ = writeln!(text, "let {name} = {call};");
}

fn function(dice: &mut Dice) -> String {
    let frequency = dice.range(1.0, 5.0);
    match dice.below(3) {
        0 => format!("|p| max(0, sin({frequency} * p.x + noise(p.y, p.z, 2 * p.x)))"),
        1 => format!("|p| [abs(p.normal.x), step(0.2, sin({frequency} * p.y)), 0.3]"),
        _ => "|p| 0.5".into(),
    }
}

fn place(dice: &mut Dice) -> String {
    let scale = match dice.below(3) {
        0 => "1".into(),
        1 => dice.range(0.4, 1.3),
        _ => format!("[{}, 1, {}]", dice.range(0.4, 1.3), dice.range(0.4, 1.3)),
    };
    let (rotate, translate) = (dice.point(40.0), dice.point(1.2));
    let visible = if dice.once_in(6) { ", visible: false" } else { "" };
    format!("#{{ scale: {scale}, rotate: {rotate}, translate: {translate}{visible} }}")
}

fn made_surface(dice: &mut Dice, names: &Names, shape: Shape) -> String {
    let (at, axis, r, h) =
        (dice.point(2.2), dice.axis(), dice.range(0.2, 0.8), dice.range(0.3, 1.0));
    let caps = dice.once_in(2);
    let keys = match shape {
        Shape::Sphere => format!("sphere(#{{ center: {at}, radius: {r}"),
        Shape::Plane => format!("plane(#{{ point: [0, -{h}, 0], normal: {axis}"),
        Shape::Quad => format!("quad(#{{ corner: {at}, u: [1.5, {r}, 0], v: [0, 1.2, {h}]"),
        Shape::Triangle => format!("triangle(#{{ a: {at}, b: [1, {r}, 3], c: [-2, 1.1, -3]"),
        Shape::Disc => format!("disc(#{{ center: {at}, normal: {axis}, radius: {r}"),
        Shape::CuboidMinMax => {
            format!("cuboid(#{{ min: [-0.5, -{r}, 0], max: [0.4, {h}, 0.7]")
        }
        Shape::Cuboid => format!("cuboid(#{{ center: {at}, size: [{r}, {h}, 0.5]"),
        Shape::Cylinder => {
            format!("cylinder(#{{ base: {at}, axis: {axis}, radius: {r}, height: {h}, caps: {caps}")
        }
        Shape::Cone => {
            format!("cone(#{{ apex: {at}, axis: {axis}, radius: {r}, height: {h}, caps: {caps}")
        }
        Shape::Paraboloid => format!(
            "paraboloid(#{{ vertex: {at}, axis: {axis}, radius: {r}, height: {h}, caps: {caps}"
        ),
        Shape::Hyperboloid => format!(
            "hyperboloid(#{{ center: {at}, axis: {axis}, radius: {r}, waist: 0.15, height: {h}, caps: {caps}"
        ),
        Shape::Ellipsoid => {
            let radii = if dice.once_in(2) {
                format!("[{r}, {r}, {r}]")
            } else {
                format!("[{r}, {h}, 0.4]")
            };
            format!("ellipsoid(#{{ center: {at}, radii: {radii}")
        }
        Shape::Torus => format!("torus(#{{ center: {at}, axis: {axis}, major: 0.9, minor: {r}"),
        Shape::Mesh => {
            let file = dice.pick(&MESHES);
            format!("mesh(#{{ file: \"{file}\", translate: {at}, rotate: [0, {r}, 0]")
        }
    };
    let hidden = if dice.once_in(8) { ", visible: false" } else { "" };
    match dice.once_in(6) {
        true => format!("{keys}{hidden} }})"),
        false => format!("{keys}{hidden}, material: {} }})", names.worn(dice, Some(shape))),
    }
}

/// A statement that changes something that is there.
fn edit(dice: &mut Dice, names: &Names, view: usize) -> String {
    match dice.below(12) {
        0 => return scene_wide(dice, view),
        1 | 2 => {
            if let Some((name, _)) = names.some(dice, |k| k == Kind::Material) {
                let key = dice.pick(&["specular", "specular", "diffuse", "ambient"]);
                return format!("{name}.{key} = {};", dice.colour());
            }
        }
        _ => {}
    }
    let Some((name, kind)) = names.some(dice, |_| true) else { return scene_wide(dice, view) };
    match kind {
        Kind::Material => format!("{name}.specular = {};", dice.colour()),
        Kind::Tiles => match dice.below(3) {
            0 => format!("{name}.even = {};", names.plain(dice)),
            1 => format!("{name}.odd = {};", names.plain(dice)),
            _ => format!("{name}.size = [{}, {}];", dice.range(0.3, 1.2), dice.range(0.3, 1.2)),
        },
        Kind::Checker => match dice.below(2) {
            0 => format!("{name}.odd = {};", names.plain(dice)),
            _ => {
                let [a, b, c] = [0; 3].map(|_| dice.range(0.2, 0.8));
                format!("{name}.size = [{a}, {b}, {c}];")
            }
        },
        Kind::Stripes => match dice.below(2) {
            0 => format!("{name}.even = {};", names.plain(dice)),
            _ => format!("{name}.width = {};", dice.range(0.1, 0.6)),
        },
        Kind::Textured => match dice.below(3) {
            0 => format!("{name}.base = {};", names.plain(dice)),
            1 => format!("{name}.file = \"{}\";", dice.pick(&PICTURES)),
            _ => format!("{name}.filter = \"{}\";", dice.pick(&["bilinear", "nearest"])),
        },
        Kind::Shader => match dice.below(2) {
            0 => format!("{name}.base = {};", names.plain(dice)),
            _ => format!("{name}.{} = {};", dice.pick(&["diffuse", "specular"]), function(dice)),
        },
        Kind::Surface(shape) => match dice.below(4) {
            0 => format!("{name}.material = {};", names.worn(dice, Some(shape))),
            1 => format!("{name}.visible = {};", dice.once_in(2)),
            _ => format!("{name}.{};", moved(dice, shape)),
        },
        Kind::Group | Kind::Instance => match dice.below(5) {
            0 => format!("{name}.visible = {};", dice.once_in(2)),
            1 => format!("{name}.scale = 1;"),
            2 => format!("{name}.scale = [1, {}, 1];", dice.range(0.5, 1.5)),
            3 => format!("{name}.rotate = {};", dice.point(90.0)),
            _ => format!("{name}.translate += {};", dice.point(0.6)),
        },
        Kind::Light => match dice.below(3) {
            0 => format!("{name}.emissivity = {};", dice.range(0.0, 20.0)),
            1 => format!("{name}.falloff = \"{}\";", dice.pick(&["inverse", "none", "square"])),
            _ => format!("{name}.at += {};", dice.point(1.0)),
        },
        Kind::Spotlight => match dice.below(3) {
            0 => format!("{name}.emissivity = {};", dice.colour()),
            1 => format!("{name}.angle = {};", dice.range(5.0, 60.0)),
            _ => format!("{name}.aim += {};", dice.point(1.0)),
        },
        Kind::Sun => match dice.below(2) {
            0 => format!("{name}.emissivity = {};", dice.colour()),
            _ => format!("{name}.direction.x += {};", dice.range(-0.5, 0.5)),
        },
        Kind::Projector => match dice.below(4) {
            0 => format!("{name}.emissivity = {};", dice.range(0.0, 20.0)),
            1 => format!("{name}.file = \"{}\";", dice.pick(&PICTURES)),
            2 => format!("{name}.angle = {};", dice.range(10.0, 40.0)),
            _ => format!("{name}.aim += {};", dice.point(0.5)),
        },
    }
}

fn scene_wide(dice: &mut Dice, view: usize) -> String {
    match dice.below(8) {
        0 => format!("picture.samples = {};", 1 + dice.below(5)),
        1 => format!("rules.max_bounces = {};", dice.below(6)),
        2 => format!("rules.max_path = {};", dice.range(4.0, 15.0)),
        3 => format!("rules.background = {};", dice.colour()),
        4 => format!("rules.attenuation = \"{}\";", dice.pick(&["inverse", "none"])),
        5 => format!("rules.transfer = \"{}\";", dice.pick(&["srgb", "linear"])),
        _ if view == 1 => format!("eye.viewpoint.x += {};", dice.range(-0.2, 0.2)),
        6 => format!("eye.look_at.y += {};", dice.range(-0.2, 0.2)),
        _ => format!("eye.eye.x += {};", dice.range(-0.2, 0.2)),
    }
}

/// A new place or form of a shape, as `property = value`.
fn moved(dice: &mut Dice, shape: Shape) -> String {
    let way = dice.point(0.5);
    let grown = dice.range(0.7, 1.4);
    let caps = dice.once_in(2);
    let (at, size) = match shape {
        Shape::Sphere => ("center", "radius"),
        Shape::Plane => return format!("point.y += {}", dice.range(-0.4, 0.4)),
        Shape::Quad => return format!("corner += {way}"),
        Shape::Triangle => return format!("a += {way}"),
        Shape::Disc => ("center", "radius"),
        Shape::CuboidMinMax => return format!("max.y *= {grown}"),
        Shape::Cuboid => ("center", "size"),
        Shape::Cylinder => ("base", "radius"),
        Shape::Cone => ("apex", "radius"),
        Shape::Paraboloid => ("vertex", "radius"),
        Shape::Hyperboloid => ("center", "height"),
        Shape::Ellipsoid => ("center", "radii"),
        Shape::Torus => ("center", "minor"),
        Shape::Mesh => {
            return match dice.below(5) {
                0 => format!("file = \"{}\"", dice.pick(&MESHES)),
                1 => format!("smooth = {}", dice.once_in(2)),
                2 => format!("scale = {grown}"),
                3 => format!("rotate.y += {}", dice.range(-30.0, 30.0)),
                _ => format!("translate += {way}"),
            };
        }
    };
    let has_caps =
        matches!(shape, Shape::Cylinder | Shape::Cone | Shape::Paraboloid | Shape::Hyperboloid);
    match dice.below(3) {
        0 if has_caps => format!("caps = {caps}"),
        0 | 1 => format!("{at} += {way}"),
        _ if shape == Shape::Torus => format!("minor = {}", dice.range(0.1, 0.8)),
        _ => format!("{size} *= {grown}"),
    }
}
