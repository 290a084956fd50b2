//! Where groups and instances show surfaces: chains of motions, and rays in a surface's own
//! coordinates. Nothing is flattened: a ray is taken through one motion after another.

use super::scene::{Handle, Of, Scene};
use super::vec3::{Vec3, v3};

/// A point p is shown at R(S p) + T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    pub translate: Vec3,
    /// About x, then y, then z, in degrees.
    pub rotate: Vec3,
    pub scale: Vec3,
}

impl Motion {
    pub const NONE: Motion =
        Motion { translate: Vec3::ZERO, rotate: Vec3::ZERO, scale: v3(1.0, 1.0, 1.0) };

    /// R v.
    fn turned(&self, v: Vec3) -> Vec3 {
        (0..3).fold(v, |v, axis| about(axis, self.rotate[axis], v))
    }

    /// R^-1 v.
    fn turned_back(&self, v: Vec3) -> Vec3 {
        (0..3).rev().fold(v, |v, axis| about(axis, -self.rotate[axis], v))
    }

    /// The point that is shown at `p`.
    pub fn point_within(&self, p: Vec3) -> Vec3 {
        self.direction_within(p - self.translate)
    }

    /// The direction that is shown as `d`, not of `d`'s length.
    pub fn direction_within(&self, d: Vec3) -> Vec3 {
        self.turned_back(d).zip(self.scale, |a, s| a / s)
    }

    /// Where `p` is shown.
    pub fn point_shown(&self, p: Vec3) -> Vec3 {
        self.turned(p.zip(self.scale, |a, s| a * s)) + self.translate
    }

    /// What is across the surface where `n` was across it: by the inverse transpose, R S^-1.
    pub fn normal_shown(&self, n: Vec3) -> Vec3 {
        self.turned(n.zip(self.scale, |a, s| a / s)).unit()
    }
}

/// `v` turned about a coordinate axis, counter-clockwise seen from the axis' tip.
fn about(axis: usize, degrees: f64, v: Vec3) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut out = v;
    out.0[i] = cos * v[i] - sin * v[j];
    out.0[j] = sin * v[i] + cos * v[j];
    out
}

/// One copy of a surface in the picture, and the motions that show it, the outermost first.
#[derive(Clone, Debug)]
pub struct Shown {
    pub surface: usize,
    pub motions: Vec<Motion>,
}

impl Shown {
    pub fn point_within(&self, p: Vec3) -> Vec3 {
        self.motions.iter().fold(p, |p, m| m.point_within(p))
    }

    /// With this direction, t is what it is in the world.
    pub fn direction_within(&self, d: Vec3) -> Vec3 {
        self.motions.iter().fold(d, |d, m| m.direction_within(d))
    }

    pub fn point_shown(&self, p: Vec3) -> Vec3 {
        self.motions.iter().rev().fold(p, |p, m| m.point_shown(p))
    }

    pub fn normal_shown(&self, n: Vec3) -> Vec3 {
        self.motions.iter().rev().fold(n, |n, m| m.normal_shown(n))
    }
}

/// All that is in the picture: every surface and thing that is in no group, as it stands.
pub fn shown(scene: &Scene) -> Vec<Shown> {
    let grouped: Vec<Handle> = scene
        .things
        .iter()
        .flat_map(|thing| match &thing.of {
            Of::Group(members) => members.clone(),
            Of::Instance(_) => Vec::new(),
        })
        .collect();
    let surfaces = (0..scene.surfaces.len()).map(Handle::Surface);
    let all = surfaces.chain((0..scene.things.len()).map(Handle::Thing));
    let mut out = Vec::new();
    for handle in all.filter(|handle| !grouped.contains(handle)) {
        show(scene, handle, Flag::Counts, &mut Vec::new(), &mut out);
    }
    out
}

/// Whether a handle's own `visible` counts: of what an instance copies it does not.
#[derive(Clone, Copy, PartialEq)]
enum Flag {
    Counts,
    Ignored,
}

fn show(
    scene: &Scene,
    handle: Handle,
    flag: Flag,
    motions: &mut Vec<Motion>,
    out: &mut Vec<Shown>,
) {
    let visible = match handle {
        Handle::Surface(i) => scene.surfaces[i].visible,
        Handle::Thing(i) => scene.things[i].visible,
    };
    if !visible && flag == Flag::Counts {
        return;
    }
    match handle {
        Handle::Surface(surface) => out.push(Shown { surface, motions: motions.clone() }),
        Handle::Thing(i) => {
            let thing = &scene.things[i];
            motions.push(thing.motion);
            match &thing.of {
                Of::Group(members) => {
                    for member in members {
                        show(scene, *member, Flag::Counts, motions, out);
                    }
                }
                Of::Instance(of) => show(scene, *of, Flag::Ignored, motions, out),
            }
            motions.pop();
        }
    }
}
