//! The rows of the table: every maker with its keys.

use crate::table::{AnyForm, Field, Form, KeyInfo, Role, Takes};
use glam::DVec3;
use reflet_scene::{
    Animation, Attenuation, Camera, Checker, Image, Key, Material, Mesh, MeshData, Plane,
    PointLight, Quad, Settings, Sphere, Spotlight, TransferCurve, Triangle,
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

use Takes::{Angles, Colour, Degrees, Direction, Factor, File, NotNegative, Paint, Point};
use Takes::{Positive, Sizes, Whole, Word};

/// All forms, in the order of the reference.
pub(crate) static FORMS: &[&dyn AnyForm] = &[
    &IMAGE, &SETTINGS, &LOOK_AT, &WINDOW, &ANIMATION, &LIGHT, &SPOTLIGHT, &MATERIAL, &CHECKER,
    &SPHERE, &PLANE, &QUAD, &TRIANGLE, &MESH,
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

static LIGHT: Form<PointLight> = Form {
    maker: "light",
    role: Role::Light,
    doc: "A light in one point, the same in all directions.",
    blank: || PointLight { at: DVec3::ZERO, emissivity: DVec3::ZERO },
    fields: &[
        field!("at", Point, None, "where it is", at),
        field!("emissivity", Colour, None, "its intensity", emissivity),
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
    },
    fields: &[
        field!("at", Point, None, "where it is", at),
        field!("aim", Point, None, "a point on the cone's axis", aim),
        field!("angle", Degrees(90.0), None, "the cone's half width", angle_degrees),
        field!("emissivity", Colour, None, "its intensity", emissivity),
    ],
    relations: Some(Spotlight::check),
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

/// The form of what wears two materials.
pub(crate) static CHECKER: Form<Checker> = Form {
    maker: "checker",
    role: Role::Checker,
    doc: "Two materials in tiles over a flat surface (plane, quad, triangle); serves as a material.",
    blank: || Checker { even: Key(0), odd: Key(0), size: [1.0, 1.0], xdir: DVec3::X },
    fields: &[
        Field {
            info: KeyInfo {
                name: "even",
                takes: Paint,
                default: None,
                doc: "the material where the sum of a tile's two numbers is even",
            },
            get: |c| Some(c.even).into(),
            set: |c, v| c.even = Option::from(v).unwrap_or(c.even),
        },
        Field {
            info: KeyInfo {
                name: "odd",
                takes: Paint,
                default: None,
                doc: "the material where it is odd",
            },
            get: |c| Some(c.odd).into(),
            set: |c, v| c.odd = Option::from(v).unwrap_or(c.odd),
        },
        field!("size", Sizes, Some("[1, 1]"), "a tile's lengths along x and y", size),
        field!("xdir", Direction, Some("[1, 0, 0]"), "the direction of x in the surface", xdir),
    ],
    relations: None,
    normal: None,
};

static SPHERE: Form<Sphere> = Form {
    maker: "sphere",
    role: Role::Surface,
    doc: "All points at the distance `radius` from `center`.",
    blank: || Sphere { center: DVec3::ZERO, radius: 1.0 },
    fields: &[
        field!("center", Point, None, "the centre", center),
        field!("radius", Positive, None, "the radius", radius),
    ],
    relations: None,
    normal: None,
};

static PLANE: Form<Plane> = Form {
    maker: "plane",
    role: Role::Surface,
    doc: "The infinite plane through `point` across `normal`.",
    blank: || Plane { point: DVec3::ZERO, normal: DVec3::Y },
    fields: &[
        field!("point", Point, None, "a point of the plane, the origin of its patterns", point),
        field!("normal", Direction, None, "the normal, of any length", normal),
    ],
    relations: None,
    normal: Some(|plane| plane.normal),
};

static QUAD: Form<Quad> = Form {
    maker: "quad",
    role: Role::Surface,
    doc: "The parallelogram `corner + s u + t v`, s and t from 0 to 1.",
    blank: || Quad { corner: DVec3::ZERO, u: DVec3::X, v: DVec3::Y },
    fields: &[
        field!(
            "corner",
            Point,
            None,
            "the corner at s = t = 0, the origin of its patterns",
            corner
        ),
        field!("u", Direction, None, "the edge along s", u),
        field!("v", Direction, None, "the edge along t", v),
    ],
    relations: Some(Quad::check),
    normal: Some(Quad::normal),
};

static TRIANGLE: Form<Triangle> = Form {
    maker: "triangle",
    role: Role::Surface,
    doc: "The triangle between three points.",
    blank: || Triangle { a: DVec3::ZERO, b: DVec3::X, c: DVec3::Y },
    fields: &[
        field!("a", Point, None, "the first corner, the origin of its patterns", a),
        field!("b", Point, None, "the second corner", b),
        field!("c", Point, None, "the third corner", c),
    ],
    relations: Some(Triangle::check),
    normal: Some(Triangle::normal),
};

static MESH: Form<Mesh> = Form {
    maker: "mesh",
    role: Role::Surface,
    doc: "Triangles from a file in the script's folder: scaled, then rotated about x, y, z, then moved.",
    blank: || Mesh {
        data: Arc::new(MeshData::default()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
    },
    fields: &[
        field!("file", File, None, "an OBJ file, relative to the script's folder", data),
        field!("scale", Factor, Some("1"), "the factor of all positions", scale),
        field!("rotate", Angles, Some("[0, 0, 0]"), "degrees about x, then y, then z", rotate),
        field!("translate", Point, Some("[0, 0, 0]"), "the way of the mesh's origin", translate),
    ],
    relations: None,
    normal: None,
};
