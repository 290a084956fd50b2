//! The rows of the table: every maker with its keys.

use crate::shapes::{
    CONE, CUBOID, CUBOID_CENTERED, CYLINDER, DISC, ELLIPSOID, HYPERBOLOID, MESH, PARABOLOID, PLANE,
    QUAD, SPHERE, TORUS, TRIANGLE,
};
use crate::table::{AnyForm, Field, Form, KeyInfo, Role, Takes};
use glam::DVec3;
use reflet_scene::{
    Animation, Attenuation, Camera, Checker, Falloff, Filter, Image, Key, Mapping, Material, Place,
    PointLight, Projector, Settings, Shader, Spotlight, Spread, Stripes, Sun, TexelFilter,
    Textured, Tiles, TransferCurve,
};
use std::sync::Arc;

/// One row: the key, what it takes, its default, what it is, and its place in the noun.
macro_rules! field {
    ($name:literal, $takes:expr, $default:expr, $doc:literal, $($place:tt)+) => {
        Field {
            info: KeyInfo { name: $name, takes: $takes, default: $default, doc: $doc },
            get: |noun| noun.$($place)+.clone().into(),
            set: |noun, value| noun.$($place)+ = value.into(),
        }
    };
}

/// A row whose place is in one variant of an enum.
macro_rules! variant {
    ($name:literal, $takes:expr, $default:expr, $doc:literal, $type:ident::$variant:ident, $place:ident, $blank:expr) => {
        Field {
            info: KeyInfo { name: $name, takes: $takes, default: $default, doc: $doc },
            get: |noun| match noun {
                $type::$variant { $place, .. } => (*$place).into(),
                _ => $blank.into(),
            },
            set: |noun, value| {
                if let $type::$variant { $place, .. } = noun {
                    *$place = value.into();
                }
            },
        }
    };
}

use Takes::Image as Picture;
use Takes::{
    Angles, Colour, Degrees, Direction, Expression, Flag, NotNegative, Paint, Point, Positive,
    Scale,
};
use Takes::{Sizes, TileSizes, Whole, Word};

pub(crate) use {field, variant};

/// All forms, in the order of the reference.
pub(crate) static FORMS: &[&dyn AnyForm] = &[
    &IMAGE,
    &SETTINGS,
    &LOOK_AT,
    &PARALLEL,
    &WINDOW,
    &ANIMATION,
    &LIGHT,
    &SPOTLIGHT,
    &SUN,
    &PROJECTOR,
    &MATERIAL,
    &CHECKER,
    &STRIPES,
    &TEXTURED,
    &SHADER,
    &SPHERE,
    &PLANE,
    &QUAD,
    &TRIANGLE,
    &DISC,
    &CUBOID,
    &CUBOID_CENTERED,
    &CYLINDER,
    &CONE,
    &PARABOLOID,
    &HYPERBOLOID,
    &ELLIPSOID,
    &TORUS,
    &MESH,
    &GROUP,
    &INSTANCE,
];

static IMAGE: Form<Image> = Form {
    maker: "image",
    role: Role::Image,
    doc: "The picture's size and samples; one in a scene.",
    blank: Image::default,
    fields: &[
        field!("width", Whole(1, Image::MAX_EDGE), Some("640"), "pixels in a row", width),
        field!("height", Whole(1, Image::MAX_EDGE), Some("360"), "rows", height),
        field!("samples", Whole(1, Image::MAX_SAMPLES), Some("1"), "samples a pixel", samples),
        Field {
            info: KeyInfo {
                name: "adaptive",
                takes: Flag,
                default: Some("false"),
                doc: "whether only pixels with an edge take the mean of `samples`, and the others what their centre sees",
            },
            get: |i| (i.spread == Spread::Edges).into(),
            set: |i, v| i.spread = if v.into() { Spread::Edges } else { Spread::Everywhere },
        },
        Field {
            info: KeyInfo {
                name: "filter",
                takes: Word(Filter::NAMES),
                default: Some("\"box\""),
                doc: "how several samples are spread around the pixel's centre: evenly within the pixel; falling evenly to the neighbours' centres; as a gaussian of sigma 0.5 pixels, cut at the neighbours' centres",
            },
            get: |i| (i.filter as usize).into(),
            set: |i, v| i.filter = Filter::ALL[<usize as From<_>>::from(v)],
        },
    ],
    relations: None,
    normal: None,
};

static SETTINGS: Form<Settings> = Form {
    maker: "settings",
    role: Role::Settings,
    doc: "What holds for the whole scene; one in a scene.",
    blank: Settings::default,
    fields: &[
        field!(
            "max_bounces",
            Whole(0, Settings::MAX_BOUNCES),
            Some("16"),
            "reflections along one path",
            max_bounces
        ),
        field!(
            "max_path",
            NotNegative,
            Some("none"),
            "a ray whose path is already longer returns 0",
            max_path
        ),
        Field {
            info: KeyInfo {
                name: "attenuation",
                takes: Word(&["inverse", "none"]),
                default: Some("\"inverse\""),
                doc: "whether an intensity is divided by the length of its path",
            },
            get: |s| usize::from(s.attenuation == Attenuation::None).into(),
            set: |s, v| {
                s.attenuation =
                    [Attenuation::Inverse, Attenuation::None][<usize as From<_>>::from(v)];
            },
        },
        field!("background", Colour, Some("0"), "what a ray that hits nothing returns", background),
        Field {
            info: KeyInfo {
                name: "transfer",
                takes: Word(&["srgb", "linear"]),
                default: Some("\"srgb\""),
                doc: "the curve of 8- and 16-bit files",
            },
            get: |s| usize::from(s.transfer == TransferCurve::Linear).into(),
            set: |s, v| {
                s.transfer =
                    [TransferCurve::Srgb, TransferCurve::Linear][<usize as From<_>>::from(v)];
            },
        },
    ],
    relations: None,
    normal: None,
};

static LOOK_AT: Form<Camera> = Form {
    maker: "camera",
    role: Role::Camera,
    doc: "Where the picture is seen from; one in a scene, which must have one.",
    blank: || Camera::LookAt {
        eye: DVec3::ZERO,
        look_at: DVec3::ZERO,
        up: DVec3::Y,
        fov_degrees: 45.0,
    },
    fields: &[
        variant!("eye", Point, None, "where the eye is", Camera::LookAt, eye, DVec3::ZERO),
        variant!(
            "look_at",
            Point,
            None,
            "the point in the middle of the picture",
            Camera::LookAt,
            look_at,
            DVec3::ZERO
        ),
        variant!(
            "up",
            Direction,
            Some("[0, 1, 0]"),
            "the direction that is up in the picture",
            Camera::LookAt,
            up,
            DVec3::Y
        ),
        variant!(
            "fov",
            Degrees(180.0),
            Some("45"),
            "the vertical field of view",
            Camera::LookAt,
            fov_degrees,
            45.0
        ),
    ],
    relations: Some(Camera::check),
    normal: None,
};

static PARALLEL: Form<Camera> = Form {
    maker: "camera",
    role: Role::Camera,
    doc: "Parallel rays instead: no perspective.",
    blank: || Camera::Parallel {
        eye: DVec3::ZERO,
        look_at: DVec3::ZERO,
        up: DVec3::Y,
        height: 1.0,
    },
    fields: &[
        variant!("eye", Point, None, "where the rays start", Camera::Parallel, eye, DVec3::ZERO),
        variant!(
            "look_at",
            Point,
            None,
            "the point in the middle of the picture",
            Camera::Parallel,
            look_at,
            DVec3::ZERO
        ),
        variant!(
            "up",
            Direction,
            Some("[0, 1, 0]"),
            "the direction that is up in the picture",
            Camera::Parallel,
            up,
            DVec3::Y
        ),
        variant!(
            "ortho",
            Positive,
            None,
            "the height that the picture shows",
            Camera::Parallel,
            height,
            1.0
        ),
    ],
    relations: Some(Camera::check),
    normal: None,
};

static WINDOW: Form<Camera> = Form {
    maker: "camera",
    role: Role::Camera,
    doc: "The classic view instead: through a window in the plane z = 0, centred at the origin.",
    blank: || Camera::Window { viewpoint: DVec3::ZERO, window: [1.0, 1.0] },
    fields: &[
        variant!(
            "viewpoint",
            Point,
            None,
            "where the eye is, not in the window's plane",
            Camera::Window,
            viewpoint,
            DVec3::ZERO
        ),
        variant!(
            "window",
            Sizes,
            None,
            "the window's width and height",
            Camera::Window,
            window,
            [1.0, 1.0]
        ),
    ],
    relations: Some(Camera::check),
    normal: None,
};

static ANIMATION: Form<Animation> = Form {
    maker: "animation",
    role: Role::Animation,
    doc: "How many pictures, how fast; one in a scene.",
    blank: Animation::default,
    fields: &[
        field!("frames", Whole(1, 10_000_000), Some("1"), "the number of frames", frames),
        field!("fps", Positive, Some("24"), "frames a second", fps),
    ],
    relations: None,
    normal: None,
};

/// The row of how a light falls with distance, for any light that has it.
macro_rules! falloff {
    () => {
        Field {
            info: KeyInfo {
                name: "falloff",
                takes: Word(&["inverse", "none", "square"]),
                default: Some("\"inverse\""),
                doc: "how it falls with the distance r: 1/r, not at all, 1/r^2",
            },
            get: |l| (l.falloff as usize).into(),
            set: |l, v| {
                let all = [Falloff::Inverse, Falloff::None, Falloff::Square];
                l.falloff = all[<usize as From<_>>::from(v)];
            },
        }
    };
}

static SUN: Form<Sun> = Form {
    maker: "sun",
    role: Role::Light,
    doc: "Light that travels in one direction from infinitely far away, the same everywhere.",
    blank: || Sun { direction: -DVec3::Y, emissivity: DVec3::ZERO },
    fields: &[
        field!("direction", Direction, None, "where it travels, of any length", direction),
        field!("emissivity", Colour, None, "its intensity", emissivity),
    ],
    relations: None,
    normal: None,
};

static LIGHT: Form<PointLight> = Form {
    maker: "light",
    role: Role::Light,
    doc: "A light in one point, the same in all directions.",
    blank: || PointLight { at: DVec3::ZERO, emissivity: DVec3::ZERO, falloff: Falloff::default() },
    fields: &[
        field!("at", Point, None, "where it is", at),
        field!("emissivity", Colour, None, "its intensity", emissivity),
        falloff!(),
    ],
    relations: None,
    normal: None,
};

static SPOTLIGHT: Form<Spotlight> = Form {
    maker: "spotlight",
    role: Role::Light,
    doc: "A light in one point that lights a cone.",
    blank: || Spotlight {
        at: DVec3::ZERO,
        aim: DVec3::ZERO,
        angle_degrees: 1.0,
        emissivity: DVec3::ZERO,
        falloff: Falloff::default(),
    },
    fields: &[
        field!("at", Point, None, "where it is", at),
        field!("aim", Point, None, "a point on the cone's axis", aim),
        field!("angle", Degrees(90.0), None, "the cone's half width", angle_degrees),
        field!("emissivity", Colour, None, "its intensity", emissivity),
        falloff!(),
    ],
    relations: Some(Spotlight::check),
    normal: None,
};

static PROJECTOR: Form<Projector> = Form {
    maker: "projector",
    role: Role::Light,
    doc: "A slide in front of a light: what it shines on shows the picture.",
    blank: || Projector {
        at: DVec3::ZERO,
        aim: DVec3::ZERO,
        up: DVec3::Y,
        angle_degrees: 1.0,
        image: Arc::default(),
        emissivity: DVec3::ZERO,
        falloff: Falloff::default(),
    },
    fields: &[
        field!("at", Point, None, "where it is", at),
        field!("aim", Point, None, "a point that the picture's middle falls on", aim),
        field!("up", Direction, Some("[0, 1, 0]"), "the direction that is up in the picture", up),
        field!("angle", Degrees(90.0), None, "half of the picture's width", angle_degrees),
        field!("file", Picture, None, "the picture, relative to the script's folder", image),
        field!("emissivity", Colour, None, "the intensity behind the slide", emissivity),
        falloff!(),
    ],
    relations: Some(Projector::check),
    normal: None,
};

/// The form of inline materials, too.
pub(crate) static MATERIAL: Form<Material> = Form {
    maker: "material",
    role: Role::Material,
    doc: "How a surface answers light.",
    blank: Material::default,
    fields: &[
        field!("ambient", Colour, Some("0"), "light that it gives off by itself", ambient),
        field!("diffuse", Colour, Some("0"), "the share of a light that is scattered", diffuse),
        field!("specular", Colour, Some("0"), "the share of the mirrored ray", specular),
    ],
    relations: None,
    normal: None,
};

/// The row of one of a pattern's two materials.
macro_rules! alternate {
    ($name:literal, $doc:literal, $place:ident) => {
        Field {
            info: KeyInfo { name: $name, takes: Paint, default: None, doc: $doc },
            get: |c| Some(c.$place).into(),
            set: |c, v| c.$place = Option::from(v).unwrap_or(c.$place),
        }
    };
}

/// The form of two materials in tiles.
pub(crate) static CHECKER: Form<Checker> = Form {
    maker: "checker",
    role: Role::Pattern,
    doc: "Two materials in tiles over a flat surface (plane, quad, triangle, disc), or with three sizes in blocks through any; serves as a material.",
    blank: || Checker { even: Key(0), odd: Key(0), size: Tiles::Flat([1.0, 1.0]), xdir: DVec3::X },
    fields: &[
        alternate!("even", "the material where the sum of a tile's numbers is even", even),
        alternate!("odd", "the material where it is odd", odd),
        field!(
            "size",
            TileSizes,
            Some("[1, 1]"),
            "a tile's lengths along x and y, or a block's along the scene's x, y and z",
            size
        ),
        field!("xdir", Direction, Some("[1, 0, 0]"), "the direction of x in a flat surface", xdir),
    ],
    relations: None,
    normal: None,
};

/// The form of two materials in stripes.
pub(crate) static STRIPES: Form<Stripes> = Form {
    maker: "stripes",
    role: Role::Pattern,
    doc: "Two materials in stripes over any surface; serves as a material.",
    blank: || Stripes { even: Key(0), odd: Key(0), width: 1.0, xdir: DVec3::X },
    fields: &[
        alternate!("even", "the material of even stripes", even),
        alternate!("odd", "the material of odd stripes", odd),
        field!("width", Positive, Some("1"), "a stripe's width", width),
        field!("xdir", Direction, Some("[1, 0, 0]"), "the direction across the stripes", xdir),
    ],
    relations: None,
    normal: None,
};

/// The row of the material that a pattern begins with.
macro_rules! base {
    ($doc:literal) => {
        Field {
            info: KeyInfo { name: "base", takes: Paint, default: None, doc: $doc },
            get: |t| Some(t.base).into(),
            set: |t, v| t.base = Option::from(v).unwrap_or(t.base),
        }
    };
}

/// The form of a material times a picture.
pub(crate) static TEXTURED: Form<Textured> = Form {
    maker: "textured",
    role: Role::Pattern,
    doc: "A material whose reflectivities are multiplied with a picture's texels; serves as a material.",
    blank: || Textured {
        base: Key(0),
        image: Arc::default(),
        mode: Mapping::Fit,
        size: [1.0, 1.0],
        xdir: DVec3::X,
        filter: TexelFilter::Bilinear,
    },
    fields: &[
        base!("the material"),
        field!("file", Picture, None, "the picture, relative to the script's folder", image),
        Field {
            info: KeyInfo {
                name: "mode",
                takes: Word(&["fit", "tile"]),
                default: Some("\"fit\""),
                doc: "once over the surface, or again and again over a flat one",
            },
            get: |t| (t.mode as usize).into(),
            set: |t, v| t.mode = [Mapping::Fit, Mapping::Tile][<usize as From<_>>::from(v)],
        },
        field!("size", Sizes, Some("[1, 1]"), "in tiles: the picture's lengths", size),
        field!("xdir", Direction, Some("[1, 0, 0]"), "in tiles: the direction of its rows", xdir),
        Field {
            info: KeyInfo {
                name: "filter",
                takes: Word(&["bilinear", "nearest"]),
                default: Some("\"bilinear\""),
                doc: "what lies between the middles of texels",
            },
            get: |t| (t.filter as usize).into(),
            set: |t, v| {
                let all = [TexelFilter::Bilinear, TexelFilter::Nearest];
                t.filter = all[<usize as From<_>>::from(v)];
            },
        },
    ],
    relations: None,
    normal: None,
};

/// The row of a reflectivity that is an expression.
macro_rules! expression {
    ($name:literal, $doc:literal, $place:ident) => {
        field!($name, Expression, Some("that of `base`"), $doc, $place)
    };
}

/// The form of a material with expressions in it.
pub(crate) static SHADER: Form<Shader> = Form {
    maker: "shader",
    role: Role::Pattern,
    doc: "A material some of whose reflectivities are functions of the hit point; serves as a material.",
    blank: || Shader { base: Key(0), ambient: None, diffuse: None, specular: None },
    fields: &[
        base!("the material, for what is not given here"),
        expression!("ambient", "light that it gives off by itself", ambient),
        expression!("diffuse", "the share of a light that is scattered", diffuse),
        expression!("specular", "the share of the mirrored ray", specular),
    ],
    relations: None,
    normal: None,
};

const PLACE: &[Field<Place>] = &[
    field!("scale", Scale, Some("1"), "the factor of all coordinates, or one each", scale),
    field!("rotate", Angles, Some("[0, 0, 0]"), "degrees about x, then y, then z", rotate),
    field!("translate", Point, Some("[0, 0, 0]"), "the way of the origin", translate),
    field!("visible", Flag, Some("true"), "whether it is in the picture at all", visible),
];

/// The form of things that are moved as a whole.
pub(crate) static GROUP: Form<Place> = Form {
    maker: "group",
    role: Role::Group,
    doc: "group([a, b, ...]) or group([a, b, ...], #{...}): surfaces, groups and instances, moved as a whole: scaled, then rotated about x, y, z, then moved. A thing is in one group at most.",
    blank: Place::default,
    fields: PLACE,
    relations: None,
    normal: None,
};

/// The form of one more copy of a thing.
pub(crate) static INSTANCE: Form<Place> = Form {
    maker: "instance",
    role: Role::Instance,
    doc: "instance(thing, #{...}): a surface, group or instance once more, put elsewhere; whether the thing itself is visible does not matter.",
    blank: Place::default,
    fields: PLACE,
    relations: None,
    normal: None,
};
