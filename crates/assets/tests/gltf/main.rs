//! glTF files as a careful reader takes them: what they hold beside triangles, how these are stored,
//! and what becomes of their materials.

mod draft;
mod geometry;
mod materials;
mod mutations;
