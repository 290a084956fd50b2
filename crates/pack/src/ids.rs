//! Indices as types.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The id as an index into its columns.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id!(
    /// A primitive: the rank of its key, the triangles of a mesh counted one by one. A tie in t goes
    /// to the lower id.
    PrimId
);
id!(
    /// A place in the columns of [`crate::Geometry`]: a primitive, or the copy of a mesh.
    Slot
);
id!(
    /// A surface as the script made it: a shape with what it wears. A mesh is one surface here.
    SurfaceId
);
id!(
    /// A row of [`crate::materials::Materials`].
    MaterialId
);
id!(
    /// A row of [`crate::lights::Lights`].
    LightId
);
