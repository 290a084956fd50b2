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
//! | [`shape`] | the roots, normals and pattern cells of surfaces |
//! | [`recursion`] | `raytrace`, as the course writes it |
//! | [`view`] | sample positions, the two cameras, whole pictures, the stability mask |
//! | [`script`] | a scene printed as a Rhai script |
//! | [`draw`] | random numbers, materials, patterns and surfaces |
//! | [`families`] | random scenes, by kind |
//! | [`compare`] | the promised tolerance |
//! | [`binary`] | the binary's picture of a script |

// Each test program includes all of this and uses a part of it.
#![allow(dead_code)]

pub mod binary;
pub mod compare;
pub mod draw;
pub mod families;
pub mod recursion;
pub mod scene;
pub mod script;
pub mod shape;
pub mod vec3;
pub mod view;
