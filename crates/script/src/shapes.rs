//! The rows of the table for shapes.

use crate::nouns::{field, variant};
use crate::table::{Field, Form, KeyInfo, Role, Takes};
use Takes::{Angles, Direction, Factor, File, Flag, Lengths, Point, Positive, Wardrobe};
use glam::DVec3;
use reflet_scene::{
    Caps, Cone, Cuboid, Cylinder, Disc, Ellipsoid, Hyperboloid, Mesh, MeshData, Paraboloid, Plane,
    Quad, Shading, Sphere, Torus, Triangle,
};
use std::sync::Arc;

pub(crate) static SPHERE: Form<Sphere> = Form {
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

pub(crate) static PLANE: Form<Plane> = Form {
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

pub(crate) static QUAD: Form<Quad> = Form {
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

pub(crate) static TRIANGLE: Form<Triangle> = Form {
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

pub(crate) static DISC: Form<Disc> = Form {
    maker: "disc",
    role: Role::Surface,
    doc: "The flat disc around `center` across `normal`.",
    blank: || Disc { center: DVec3::ZERO, normal: DVec3::Y, radius: 1.0 },
    fields: &[
        field!("center", Point, None, "the centre, the origin of its patterns", center),
        field!("normal", Direction, None, "the normal, of any length", normal),
        field!("radius", Positive, None, "the radius", radius),
    ],
    relations: None,
    normal: Some(|disc| disc.normal),
};

pub(crate) static CUBOID: Form<Cuboid> = Form {
    maker: "cuboid",
    role: Role::Surface,
    doc: "A box along the scene's axes, between two corners.",
    blank: || Cuboid::Corners { min: DVec3::ZERO, max: DVec3::ONE },
    fields: &[
        variant!("min", Point, None, "the least x, y, z", Cuboid::Corners, min, DVec3::ZERO),
        variant!("max", Point, None, "the greatest x, y, z", Cuboid::Corners, max, DVec3::ONE),
    ],
    relations: Some(Cuboid::check),
    normal: None,
};

pub(crate) static CUBOID_CENTERED: Form<Cuboid> = Form {
    maker: "cuboid",
    role: Role::Surface,
    doc: "The same around a point.",
    blank: || Cuboid::Centered { center: DVec3::ZERO, size: DVec3::ONE },
    fields: &[
        variant!("center", Point, None, "the middle", Cuboid::Centered, center, DVec3::ZERO),
        variant!(
            "size",
            Lengths,
            None,
            "the lengths along x, y and z",
            Cuboid::Centered,
            size,
            DVec3::ONE
        ),
    ],
    relations: Some(Cuboid::check),
    normal: None,
};

/// The row of whether the ends of an open quadric are closed.
macro_rules! caps {
    ($doc:literal) => {
        Field {
            info: KeyInfo { name: "caps", takes: Flag, default: Some("false"), doc: $doc },
            get: |q| (q.caps == Caps::Closed).into(),
            set: |q, v| q.caps = if v.into() { Caps::Closed } else { Caps::Open },
        }
    };
}

pub(crate) static CYLINDER: Form<Cylinder> = Form {
    maker: "cylinder",
    role: Role::Surface,
    doc: "A tube of `radius` around the axis, from `base` as long as `height`.",
    blank: || Cylinder {
        base: DVec3::ZERO,
        axis: DVec3::Y,
        radius: 1.0,
        height: 1.0,
        caps: Caps::Open,
    },
    fields: &[
        field!("base", Point, None, "where the axis begins", base),
        field!("axis", Direction, None, "the axis' direction, of any length", axis),
        field!("radius", Positive, None, "the radius", radius),
        field!("height", Positive, None, "the length along the axis", height),
        caps!("whether both ends are closed"),
    ],
    relations: None,
    normal: None,
};

pub(crate) static CONE: Form<Cone> = Form {
    maker: "cone",
    role: Role::Surface,
    doc: "A cone that opens from `apex` along the axis.",
    blank: || Cone {
        apex: DVec3::ZERO,
        axis: DVec3::Y,
        radius: 1.0,
        height: 1.0,
        caps: Caps::Open,
    },
    fields: &[
        field!("apex", Point, None, "the point", apex),
        field!("axis", Direction, None, "the axis' direction, of any length", axis),
        field!("radius", Positive, None, "the radius at `height`", radius),
        field!("height", Positive, None, "the length along the axis", height),
        caps!("whether the wide end is closed"),
    ],
    relations: None,
    normal: None,
};

pub(crate) static PARABOLOID: Form<Paraboloid> = Form {
    maker: "paraboloid",
    role: Role::Surface,
    doc: "A bowl that opens from `vertex` along the axis: the radius grows as the root of the length.",
    blank: || Paraboloid {
        vertex: DVec3::ZERO,
        axis: DVec3::Y,
        radius: 1.0,
        height: 1.0,
        caps: Caps::Open,
    },
    fields: &[
        field!("vertex", Point, None, "the bowl's lowest point", vertex),
        field!("axis", Direction, None, "the axis' direction, of any length", axis),
        field!("radius", Positive, None, "the radius at `height`", radius),
        field!("height", Positive, None, "the length along the axis", height),
        caps!("whether the wide end is closed"),
    ],
    relations: None,
    normal: None,
};

pub(crate) static HYPERBOLOID: Form<Hyperboloid> = Form {
    maker: "hyperboloid",
    role: Role::Surface,
    doc: "A hyperboloid of one sheet: a tube that is narrowest at `center`.",
    blank: || Hyperboloid {
        center: DVec3::ZERO,
        axis: DVec3::Y,
        radius: 1.0,
        waist: 0.5,
        height: 1.0,
        caps: Caps::Open,
    },
    fields: &[
        field!("center", Point, None, "the middle of the waist", center),
        field!("axis", Direction, None, "the axis' direction, of any length", axis),
        field!("radius", Positive, None, "the radius at both ends", radius),
        field!("waist", Positive, None, "the radius in the middle, less than `radius`", waist),
        field!("height", Positive, None, "the length from the middle to an end", height),
        caps!("whether both ends are closed"),
    ],
    relations: Some(Hyperboloid::check),
    normal: None,
};

pub(crate) static ELLIPSOID: Form<Ellipsoid> = Form {
    maker: "ellipsoid",
    role: Role::Surface,
    doc: "A sphere drawn out along the scene's axes.",
    blank: || Ellipsoid { center: DVec3::ZERO, radii: DVec3::ONE },
    fields: &[
        field!("center", Point, None, "the centre", center),
        field!("radii", Lengths, None, "the half axes along x, y and z", radii),
    ],
    relations: None,
    normal: None,
};

pub(crate) static TORUS: Form<Torus> = Form {
    maker: "torus",
    role: Role::Surface,
    doc: "A ring around the axis.",
    blank: || Torus { center: DVec3::ZERO, axis: DVec3::Y, major: 1.0, minor: 0.25 },
    fields: &[
        field!("center", Point, None, "the middle of the hole", center),
        field!("axis", Direction, None, "the axis' direction, through the hole", axis),
        field!("major", Positive, None, "the radius of the ring", major),
        field!("minor", Positive, None, "the radius of its tube, less than `major`", minor),
    ],
    relations: Some(Torus::check),
    normal: None,
};

pub(crate) static MESH: Form<Mesh> = Form {
    maker: "mesh",
    role: Role::Surface,
    doc: "Triangles from a file (OBJ, PLY, STL, glTF or GLB) in the script's folder: scaled, then rotated about x, y, z, then moved.",
    blank: || Mesh {
        data: Arc::new(MeshData::default()),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        shading: Shading::Smooth,
        worn: [].into(),
    },
    fields: &[
        field!("file", File, None, "the file, relative to the script's folder", data),
        field!("scale", Factor, Some("1"), "the factor of all positions", scale),
        field!("rotate", Angles, Some("[0, 0, 0]"), "degrees about x, then y, then z", rotate),
        field!("translate", Point, Some("[0, 0, 0]"), "the way of the mesh's origin", translate),
        Field {
            info: KeyInfo {
                name: "smooth",
                takes: Flag,
                default: Some("true"),
                doc: "whether the file's own normals are used, if it has them",
            },
            get: |m| (m.shading == Shading::Smooth).into(),
            set: |m, v| m.shading = if v.into() { Shading::Smooth } else { Shading::Faceted },
        },
        Field {
            info: KeyInfo {
                name: "materials",
                takes: Wardrobe,
                default: Some("those of the file"),
                doc: "the file's own materials by name, which the mesh wears while it has no `material`; a map puts others in place of those that it names",
            },
            get: |m| m.worn.to_vec().into(),
            set: |m, v| m.wear(v.into()),
        },
    ],
    relations: Some(Mesh::check),
    normal: None,
};
