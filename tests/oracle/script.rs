//! A scene printed as a script, so that the binary can render the very same one.

use super::filter::PixelFilter;
use super::place::Motion;
use super::scene::{
    Attenuation, Camera, Checker, Falloff, Handle, Light, Material, Of, Pattern, Scene, Settings,
    Shape, Wears,
};
use super::shader::Function;
use super::texture::Filter;
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
    let Scene { width, height, samples, filter, .. } = scene;
    write!(out, "image(#{{ width: {width}, height: {height}")?;
    if *samples != 1 {
        write!(out, ", samples: {samples}")?;
    }
    if *filter != PixelFilter::Box {
        write!(out, ", filter: \"{}\"", filter.name())?;
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
        Camera::Ortho { eye, look_at, up, height } => writeln!(
            out,
            "camera(#{{ eye: {}, look_at: {}, up: {}, ortho: {} }});",
            vector(eye),
            vector(look_at),
            vector(up),
            number(height)
        )?,
    }
    for light in &scene.lights {
        self::light(out, scene, light)?;
    }
    for sun in &scene.suns {
        let (direction, emissivity) = (vector(sun.direction), colour(sun.emissivity));
        writeln!(out, "sun(#{{ direction: {direction}, emissivity: {emissivity} }});")?;
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
    for (i, pattern) in scene.patterns.iter().enumerate() {
        writeln!(out, "let p{i} = {};", self::pattern(scene, pattern))?;
    }
    for (i, surface) in scene.surfaces.iter().enumerate() {
        let wears = match surface.wears {
            Wears::Material(i) => format!("m{i}"),
            Wears::Checker(i) => format!("c{i}"),
            Wears::Pattern(i) => format!("p{i}"),
            Wears::File => String::new(),
        };
        let wears = if wears.is_empty() { wears } else { format!(", material: {wears}") };
        let visible = if surface.visible { "" } else { ", visible: false" };
        // Named only where something names it.
        let name = if scene.things.is_empty() { String::new() } else { format!("let s{i} = ") };
        writeln!(out, "{name}{}{wears}{visible} }});", shape(&surface.shape))?;
    }
    for (i, thing) in scene.things.iter().enumerate() {
        let moved = motion(&thing.motion, thing.visible);
        match &thing.of {
            Of::Group(members) => {
                let members: Vec<String> = members.iter().map(|m| handle(*m)).collect();
                writeln!(out, "let t{i} = group([{}], {moved});", members.join(", "))?;
            }
            Of::Instance(of) => writeln!(out, "let t{i} = instance({}, {moved});", handle(*of))?,
        }
    }
    Ok(())
}

fn light(out: &mut String, scene: &Scene, light: &Light) -> std::fmt::Result {
    let (at, emissivity) = (vector(light.at), colour(light.emissivity));
    let falloff = match light.falloff {
        Falloff::Inverse => "",
        Falloff::None => ", falloff: \"none\"",
        Falloff::Square => ", falloff: \"square\"",
    };
    match (&light.cone, &light.slide) {
        (None, None) => write!(out, "light(#{{ at: {at}")?,
        (Some(cone), _) => write!(
            out,
            "spotlight(#{{ at: {at}, aim: {}, angle: {}",
            vector(cone.aim),
            number(cone.half_width_degrees)
        )?,
        (None, Some(slide)) => write!(
            out,
            "projector(#{{ at: {at}, aim: {}, up: {}, angle: {}, file: \"{}\"",
            vector(slide.aim),
            vector(slide.up),
            number(slide.half_width_degrees),
            scene.textures[slide.texture].file
        )?,
    }
    writeln!(out, ", emissivity: {emissivity}{falloff} }});")
}

fn pattern(scene: &Scene, pattern: &Pattern) -> String {
    let quality = |filter: Filter| match filter {
        Filter::Bilinear => "bilinear",
        Filter::Nearest => "nearest",
    };
    match *pattern {
        Pattern::Solid { even, odd, size } => format!(
            "checker(#{{ even: m{even}, odd: m{odd}, size: {} }})",
            vector(super::vec3::Vec3(size))
        ),
        Pattern::Stripes { even, odd, width, xdir } => format!(
            "stripes(#{{ even: m{even}, odd: m{odd}, width: {}, xdir: {} }})",
            number(width),
            vector(xdir)
        ),
        Pattern::Fit { base, texture, filter } => format!(
            "textured(#{{ base: m{base}, file: \"{}\", filter: \"{}\" }})",
            scene.textures[texture].file,
            quality(filter)
        ),
        Pattern::Tile { base, texture, filter, size, xdir } => format!(
            "textured(#{{ base: m{base}, file: \"{}\", mode: \"tile\", filter: \"{}\", size: [{}, {}], xdir: {} }})",
            scene.textures[texture].file,
            quality(filter),
            number(size[0]),
            number(size[1]),
            vector(xdir)
        ),
        Pattern::Shader { base, shader } => {
            let parts: Vec<String> = [
                ("ambient", shader.ambient),
                ("diffuse", shader.diffuse),
                ("specular", shader.specular),
            ]
            .iter()
            .filter_map(|(name, f)| f.map(|f| format!(", {name}: {}", function(&f))))
            .collect();
            format!("shader(#{{ base: m{base}{} }})", parts.join(""))
        }
    }
}

/// A shader's function, with its numbers in place of their names.
fn function(f: &Function) -> String {
    let mut text = f.code.script.to_owned();
    for (i, k) in f.k.iter().enumerate() {
        text = text.replace(&format!("k{i}"), &number(*k));
    }
    format!("|p| {text}")
}

fn handle(handle: Handle) -> String {
    match handle {
        Handle::Surface(i) => format!("s{i}"),
        Handle::Thing(i) => format!("t{i}"),
    }
}

/// The map of a group or an instance, with what is not its default.
fn motion(motion: &Motion, visible: bool) -> String {
    let mut parts = Vec::new();
    if motion.translate != Motion::NONE.translate {
        parts.push(format!("translate: {}", vector(motion.translate)));
    }
    if motion.rotate != Motion::NONE.rotate {
        parts.push(format!("rotate: {}", vector(motion.rotate)));
    }
    if motion.scale != Motion::NONE.scale {
        // One number for all three, as for a grey.
        parts.push(format!("scale: {}", colour(motion.scale)));
    }
    if !visible {
        parts.push("visible: false".to_owned());
    }
    format!("#{{ {} }}", parts.join(", "))
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
        Shape::Mesh { mesh } => {
            let Motion { translate, rotate, scale } = mesh.place;
            let smooth = if mesh.smooth { "" } else { ", smooth: false" };
            format!(
                "mesh(#{{ file: \"{}\", scale: {}, rotate: {}, translate: {}{smooth}",
                mesh.file,
                number(scale[0]),
                vector(rotate),
                vector(translate)
            )
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
        Shape::Disc { center, normal, radius } => format!(
            "disc(#{{ center: {}, normal: {}, radius: {}",
            vector(center),
            vector(normal),
            number(radius)
        ),
        Shape::Cuboid { min, max } => {
            format!("cuboid(#{{ min: {}, max: {}", vector(min), vector(max))
        }
        Shape::Cylinder { base, axis, radius, height, caps } => {
            format!("cylinder(#{{ base: {}, {}", vector(base), turned(axis, radius, height, caps))
        }
        Shape::Cone { apex, axis, radius, height, caps } => {
            format!("cone(#{{ apex: {}, {}", vector(apex), turned(axis, radius, height, caps))
        }
        Shape::Paraboloid { vertex, axis, radius, height, caps } => {
            let rest = turned(axis, radius, height, caps);
            format!("paraboloid(#{{ vertex: {}, {rest}", vector(vertex))
        }
        Shape::Hyperboloid { center, axis, radius, waist, height, caps } => {
            let rest = turned(axis, radius, height, caps);
            format!("hyperboloid(#{{ center: {}, waist: {}, {rest}", vector(center), number(waist))
        }
        Shape::Ellipsoid { center, radii } => {
            format!("ellipsoid(#{{ center: {}, radii: {}", vector(center), vector(radii))
        }
        Shape::Torus { center, axis, major, minor } => format!(
            "torus(#{{ center: {}, axis: {}, major: {}, minor: {}",
            vector(center),
            vector(axis),
            number(major),
            number(minor)
        ),
    }
}

/// The keys that all quadrics have.
fn turned(axis: Vec3, radius: f64, height: f64, caps: bool) -> String {
    let caps = if caps { ", caps: true" } else { "" };
    format!("axis: {}, radius: {}, height: {}{caps}", vector(axis), number(radius), number(height))
}
