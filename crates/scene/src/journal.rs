//! Old values, so that a frame can be undone and `pack` knows which rows to look at.

use crate::key::Key;

macro_rules! nouns {
    ($($noun:ident),+ $(,)?) => {
        /// A component's value before it was written.
        #[derive(Clone, Debug)]
        pub(crate) enum Old {
            $(#[allow(missing_docs)] $noun(Key, crate::$noun),)+
        }

        impl Old {
            /// Whose value it is.
            pub(crate) fn key(&self) -> Key {
                match self { $(Old::$noun(key, _) => *key,)+ }
            }

            /// Writes the value back, unjournaled.
            pub(crate) fn restore(self, scene: &mut crate::Scene) {
                match self { $(Old::$noun(key, value) => scene.overwrite(key, value),)+ }
            }
        }

        $(
            impl Sealed for crate::$noun {
                fn old(self, key: Key) -> Old { Old::$noun(key, self) }
            }
            impl Noun for crate::$noun {}
        )+
    };
}

pub(crate) trait Sealed: Sized {
    fn old(self, key: Key) -> Old;
}

/// A component that scripts read and write: one of this crate's nouns.
#[allow(private_bounds)]
pub trait Noun: hecs::Component + Clone + Sealed {}

nouns!(
    Sphere,
    Plane,
    Quad,
    Triangle,
    Disc,
    Cuboid,
    Cylinder,
    Cone,
    Paraboloid,
    Hyperboloid,
    Ellipsoid,
    Torus,
    Group,
    Instance,
    Place,
    Mesh,
    Surface,
    Material,
    Mapped,
    Checker,
    Stripes,
    Textured,
    Shader,
    PointLight,
    Spotlight,
    Sun,
    Projector,
    Camera,
    Image,
    Settings,
    Animation,
    RandomStream,
);
