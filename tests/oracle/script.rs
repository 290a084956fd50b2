//! A scene printed as a script, so that the binary can render the very same one.

use super::scene::{Attenuation, Camera, Checker, Material, Scene, Settings, Shape, Wears};
use super::vec3::Vec3;
use std::fmt::Write as _;

/// `x` in decimals that parse back to the same f64, never with an exponent.
pub fn number(x: f64) -> String {
    let text = format!("{x}");
    if text.contains('.') { text } else { text + ".0" }
}

fn vector(v: Vec3) -> String {
    format!("[{}, {}, {}]", number(v[0]), number(v[1]), number(v[2]))
}

/// A grey as one number, any other colour as three.
fn colour(v: Vec3) -> String {
    if v == Vec3::splat(v[0]) { number(v[0]) } else { vector(v) }
}

/// The script whose picture is that of `scene`.
pub fn script(scene: &Scene) -> String {
    let mut out = String::new();
    write_script(&mut out, scene).expect("writing to a string");
    out
}

fn write_script(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let Scene { width, height, samples, .. } = scene;
    write!(out, "image(#{{ width: {width}, height: {height}")?;
    if *samples != 1 {
        write!(out, ", samples: {samples}")?;
    }
    writeln!(out, " }});")?;
    settings(out, &scene.settings)?;
    match scene.camera {
        Camera::LookAt { eye, look_at, up, fov_degrees } => writeln!(
            out,
            "camera(#{{ eye: {}, look_at: {}, up: {}, fov: {} }});",
            vector(eye),
            vector(look_at),
            vector(up),
            number(fov_degrees)
        )?,
        Camera::Window { viewpoint, window } => writeln!(
            out,
            "camera(#{{ viewpoint: {}, window: [{}, {}] }});",
            vector(viewpoint),
            number(window[0]),
            number(window[1])
        )?,
    }
    for light in &scene.lights {
        let (at, emissivity) = (vector(light.at), colour(light.emissivity));
        match light.cone {
            None => writeln!(out, "light(#{{ at: {at}, emissivity: {emissivity} }});")?,
            Some(cone) => writeln!(
                out,
                "spotlight(#{{ at: {at}, aim: {}, angle: {}, emissivity: {emissivity} }});",
                vector(cone.aim),
                number(cone.half_width_degrees)
            )?,
        }
    }
    for (i, material) in scene.materials.iter().enumerate() {
        writeln!(out, "let m{i} = {};", self::material(material))?;
    }
    for (i, Checker { even, odd, size, xdir }) in scene.checkers.iter().enumerate() {
        writeln!(
            out,
            "let c{i} = checker(#{{ even: m{even}, odd: m{odd}, size: [{}, {}], xdir: {} }});",
            number(size[0]),
            number(size[1]),
            vector(*xdir)
        )?;
    }
    for surface in &scene.surfaces {
        let wears = match surface.wears {
            Wears::Material(i) => format!("m{i}"),
            Wears::Checker(i) => format!("c{i}"),
        };
        writeln!(out, "{}, material: {wears} }});", shape(&surface.shape))?;
    }
    Ok(())
}

fn settings(out: &mut String, settings: &Settings) -> std::fmt::Result {
    write!(out, "settings(#{{ max_bounces: {}", settings.max_bounces)?;
    if settings.max_path.is_finite() {
        write!(out, ", max_path: {}", number(settings.max_path))?;
    }
    if settings.attenuation == Attenuation::None {
        write!(out, ", attenuation: \"none\"")?;
    }
    if settings.background != Vec3::ZERO {
        write!(out, ", background: {}", colour(settings.background))?;
    }
    writeln!(out, " }});")
}

/// A material with the values that are not 0, its default.
fn material(material: &Material) -> String {
    let parts: Vec<String> = [
        ("ambient", material.ambient),
        ("diffuse", material.diffuse),
        ("specular", material.specular),
    ]
    .iter()
    .filter(|(_, value)| *value != Vec3::ZERO)
    .map(|(name, value)| format!("{name}: {}", colour(*value)))
    .collect();
    if parts.is_empty() {
        "material(#{ diffuse: 0 })".to_owned()
    } else {
        format!("material(#{{ {} }})", parts.join(", "))
    }
}

/// The call that makes a shape, up to its material.
fn shape(shape: &Shape) -> String {
    match *shape {
        Shape::Sphere { center, radius } => {
            format!("sphere(#{{ center: {}, radius: {}", vector(center), number(radius))
        }
        Shape::Plane { point, normal } => {
            format!("plane(#{{ point: {}, normal: {}", vector(point), vector(normal))
        }
        Shape::Quad { corner, u, v } => {
            format!("quad(#{{ corner: {}, u: {}, v: {}", vector(corner), vector(u), vector(v))
        }
        Shape::Triangle { a, b, c } => {
            format!("triangle(#{{ a: {}, b: {}, c: {}", vector(a), vector(b), vector(c))
        }
    }
}
