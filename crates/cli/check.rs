//! `reflet check SCRIPT`: what a scene holds, and what looks wrong with it.
//!
//! | room | holds |
//! | --- | --- |
//! | [`shapes`] | the visible surfaces, by kind |
//! | [`survey`] | how much of what |
//! | [`coincident`] | surfaces in one place, with [`flat`] for those in one plane |
//! | [`nearby`] | lights on surfaces, the camera in a solid |
//! | [`findings`] | the warnings, each once |

mod coincident;
mod findings;
mod flat;
mod nearby;
pub mod shapes;
mod survey;

use crate::console::Console;
use crate::exit::Failure;
use crate::meant::Script;
use crate::progress::bytes;
use findings::Findings;
use reflet_scene::{Camera, Filter, Key, Scene, Spread};
use reflet_script::Stage;
use shapes::{Names, Shapes, number, point};
use std::fmt::Write as _;
use survey::{Survey, counted};

/// Warnings of a kind that are told one by one.
const TOLD: usize = 10;

/// Builds the scene, looks at its first and last frame, and gives the report for stdout; warnings go
/// to the console.
///
/// # Errors
/// The script cannot be read, or is wrong by itself or in one of the two frames.
pub fn run(script: &Script, console: &Console) -> Result<String, Failure> {
    let mut stage = script.load()?;
    let operations = stage.operations();
    let animation = stage.with_scene(Scene::animation);
    let mut findings = Findings::default();
    stage.frame(0)?;
    let mut report = format!("{}\n", script.path.display());
    stage.with_scene(|scene| {
        let shapes = Shapes::of(scene);
        look(scene, &shapes, &mut findings);
        report += &describe(scene, &shapes);
    });
    if stage.has_frame_functions() && animation.frames > 1 {
        let last = animation.frames - 1;
        stage.frame(last)?;
        findings.suffix = format!(" (in frame {last})");
        stage.with_scene(|scene| look(scene, &Shapes::of(scene), &mut findings));
    }
    report += &parameters(&stage);
    let _ = writeln!(report, "script      {}", counted(operations, "operation"));
    let warnings = stage.warnings();
    let count = warnings.len() as u64 + findings.len();
    for line in warnings.iter().map(ToString::to_string).chain(findings.lines(TOLD)) {
        console.warn(&line);
    }
    let _ = match count {
        0 => writeln!(report, "no warnings"),
        n => writeln!(report, "{}", counted(n, "warning")),
    };
    Ok(report)
}

fn look(scene: &Scene, shapes: &Shapes, findings: &mut Findings) {
    let names = Names::of(scene);
    let name = |key: Key| names.name(scene, key);
    coincident::find(shapes, &name, findings);
    nearby::find(scene, shapes, &name, findings);
}

fn describe(scene: &Scene, shapes: &Shapes) -> String {
    let survey = Survey::of(scene, shapes);
    let (image, animation) = (scene.image(), scene.animation());
    let filter = match image.filter {
        Filter::Box => String::new(),
        filter => format!(" through a {} filter", filter.name()),
    };
    let edges = if image.spread == Spread::Edges { " with an edge" } else { "" };
    let mut text = format!(
        "picture     {}x{}, {} a pixel{edges}{filter}\n",
        image.width,
        image.height,
        counted(image.samples.into(), "sample")
    );
    let _ = match animation.frames {
        1 => writeln!(text, "frames      1, a still"),
        n => writeln!(
            text,
            "frames      {n}, {} a second ({} s)",
            number(animation.fps),
            number(f64::from(n) / animation.fps)
        ),
    };
    let _ = match scene.singletons.camera.and_then(|key| scene.get(key)) {
        Some(Camera::LookAt { eye, look_at, fov_degrees, .. }) => writeln!(
            text,
            "camera      at {}, looking at {}, {} degrees high",
            point(eye),
            point(look_at),
            number(fov_degrees)
        ),
        Some(Camera::Parallel { eye, look_at, height, .. }) => writeln!(
            text,
            "camera      at {}, looking at {}, parallel rays, {} high",
            point(eye),
            point(look_at),
            number(height)
        ),
        Some(Camera::Window { viewpoint, window: [width, height] }) => writeln!(
            text,
            "camera      at {}, through a window of {} x {}",
            point(viewpoint),
            number(width),
            number(height)
        ),
        None => writeln!(text, "camera      none"),
    };
    let _ = write!(text, "{survey}");
    let memory = survey::memory(scene, shapes, &survey);
    let _ = writeln!(text, "memory      about {} for an 8-bit render", bytes(memory));
    text
}

fn parameters(stage: &Stage) -> String {
    let mut text = String::new();
    for p in stage.parameters() {
        let range = format!("{} to {}", number(p.low), number(p.high));
        let _ = writeln!(text, "parameter   {} = {}, {range}", p.name, number(p.value));
    }
    text
}
