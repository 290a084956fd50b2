//! The shading model once more, as the plain recursion in f64: an independent second opinion.
//!
//! Nothing here uses a crate of the project. A scene is a small struct of f64s that can render
//! itself by the recursion, print itself as a scene script for the binary, be drawn at random from
//! a seed, and say which of its pixels are stable enough to be compared.
//!
//! | room | holds |
//! | --- | --- |
//! | [`vec3`] | three f64s with the few operations that the recursion needs |
//! | [`scene`] | the description of a scene |
//! | [`shape`] | the roots and normals of surfaces, and where their patterns start |
//! | [`quadric`], [`polynomial`] | the roots of surfaces around an axis |
//! | [`mesh`] | triangles of files |
//! | [`uv`] | the (u, v) of surfaces |
//! | [`place`] | groups and instances: what is shown where |
//! | [`pattern`], [`texture`], [`shader`] | what a surface wears at a point |
//! | [`lamp`] | what lights give to a point |
//! | [`recursion`] | `raytrace`, as the course writes it |
//! | [`filter`] | where a filter puts sample positions |
//! | [`view`] | sample positions, the cameras, whole pictures, the stability mask |
//! | [`script`] | a scene printed as a Rhai script |
//! | [`draw`], [`draw_words`] | random numbers, materials, patterns, surfaces and lights |
//! | [`families`], [`words`] | random scenes, by kind |
//! | [`compare`] | the promised tolerance |
//! | [`hand`] | scenes of a few pixels, for cases worked out by hand |
//! | [`hold`] | whole families held against the binary |
//! | [`binary`] | the binary's picture of a script |

// Each test program includes all of this and uses a part of it.
#![allow(dead_code)]

pub mod binary;
pub mod compare;
pub mod draw;
pub mod draw_words;
pub mod families;
pub mod filter;
pub mod hand;
pub mod hold;
pub mod lamp;
pub mod mesh;
pub mod pattern;
pub mod place;
pub mod polynomial;
pub mod quadric;
pub mod recursion;
pub mod scene;
pub mod script;
pub mod shader;
pub mod shape;
pub mod texture;
pub mod uv;
pub mod vec3;
pub mod view;
pub mod words;
