//! `reflet check SCRIPT`: what a scene holds, and what looks wrong with it.
//!
//! | room | holds |
//! | --- | --- |
//! | [`shapes`] | the visible surfaces, by kind |
//! | [`survey`] | how much of what |
//! | [`coincident`] | surfaces in one place, with [`flat`] for those in one plane |
//! | [`nearby`] | lights on surfaces, the camera in a solid |
//! | [`sight`] | what rays tell: nothing in view, a light that is shut in |
//! | [`colours`] | colours that seem to be meant in 0..255 |
//! | [`course`] | what holds in all frames |
//! | [`findings`] | the warnings, each once |

mod coincident;
mod colours;
mod course;
mod findings;
mod flat;
mod nearby;
pub mod shapes;
mod sight;
mod survey;

use crate::args::ScriptArgs;
use crate::console::Console;
use crate::exit::Failure;
use crate::frames::FrameRanges;
use crate::meant::Script;
use crate::params;
use crate::progress::bytes;
use course::Course;
use findings::{Findings, Kind};
use reflet_scene::{Camera, DVec3, Filter, Key, Scene, Spread, Sun};
use reflet_script::Stage;
use shapes::{Names, Shapes, number, point};
use sight::{Sight, Within};
use std::fmt::Write as _;
use std::str::FromStr;
use survey::{Survey, counted};

/// Warnings of a kind that are told one by one.
const TOLD: usize = 10;
/// So many frames are run without being asked for: the first, the last, and some in between.
const SAMPLE: u32 = 16;
/// So many more are, where what was found holds only if it holds in all of them.
const MORE: usize = 500;

/// What `check` takes.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    #[command(flatten)]
    pub script: ScriptArgs,
    /// The frames to run: all, or ranges as for `render`; without it the first, the last, and some
    /// in between
    #[arg(long, value_name = "RANGES", allow_hyphen_values = true)]
    pub frames: Option<Frames>,
}

/// Which frames are run.
#[derive(Clone, Debug)]
pub enum Frames {
    /// All.
    All,
    /// These.
    These(FrameRanges),
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        text.parse().map(Self::These).map_err(|e| format!("{e}; or all"))
    }
}

impl Frames {
    /// The frames of an animation of `count`, ascending.
    fn of(frames: Option<&Frames>, count: u32) -> Result<Vec<u32>, Failure> {
        match frames {
            Some(Self::These(ranges)) => ranges.within(count).map_err(Failure::usage),
            None if count > SAMPLE => {
                let at = |i: u32| u64::from(i) * u64::from(count - 1) / u64::from(SAMPLE - 1);
                Ok((0..SAMPLE).map(|i| at(i) as u32).collect())
            }
            None | Some(Self::All) => Ok((0..count).collect()),
        }
    }
}

/// Builds the scene, runs some of its frames, and gives the report for stdout; warnings go to the
/// console. Surfaces and lights are looked at in the first and the last of the frames.
///
/// # Errors
/// The script cannot be read, or is wrong by itself or in one of the frames.
pub fn run(script: &Script, frames: Option<&Frames>, console: &Console) -> Result<String, Failure> {
    let mut stage = script.load()?;
    let operations = stage.operations();
    let count = stage.with_scene(Scene::animation).frames;
    let chosen = Frames::of(frames, count)?;
    let ends = [chosen.first().copied(), chosen.last().copied()];
    let mut findings = Findings::default();
    let mut report = format!("{}\n", script.path.display());
    let mut course = stage.with_scene(Course::of);
    for frame in &chosen {
        stage.frame(*frame)?;
        if let Some(course) = &mut course {
            stage.with_scene(|scene| course.take(scene));
        }
        if ends[0] == Some(*frame) {
            report += &stage.with_scene(|scene| describe(scene, &Shapes::of(scene)));
        } else if ends[1] == Some(*frame) {
            findings.suffix = format!(" (in frame {frame})");
        }
        if ends.contains(&Some(*frame)) {
            look(&stage, course.as_ref(), &mut findings);
        }
    }
    if let Some(course) = &mut course {
        // Without a frame function all frames are the same.
        let others = (0..count).filter(|frame| chosen.binary_search(frame).is_err());
        for frame in others.take(if stage.has_frame_functions() { MORE } else { 0 }) {
            if !course.open() {
                break;
            }
            stage.frame(frame)?;
            stage.with_scene(|scene| course.take(scene));
        }
        findings.suffix.clear();
        course.tell(&stage, count, &mut findings);
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

/// Looks at one frame.
fn look(stage: &Stage, course: Option<&Course>, findings: &mut Findings) {
    let (colours, enclosed) = stage.with_scene(|scene| {
        let (shapes, names) = (Shapes::of(scene), Names::of(scene));
        let name = |key: Key| names.name(scene, key);
        coincident::find(&shapes, &name, findings);
        let columns = course.map(Course::columns);
        let middles: Vec<_> = columns.into_iter().flat_map(sight::middles).collect();
        let astray = nearby::find(scene, &shapes, &middles, &name, findings);
        let sight = columns.and_then(Sight::new);
        let mut enclosed = enclosed(scene, sight);
        // Of a camera that strayed into a solid that is told, and the lights are where they were.
        enclosed.retain(|(.., within)| *within == Within::Light || !astray);
        (colours::find(scene), enclosed)
    });
    for (light, surface, within) in enclosed {
        findings.add(Kind::Enclosed, || {
            let (light, surface) = (stage.name_of(light), stage.name_of(surface));
            match within {
                Within::Light => {
                    format!("{light} is inside {surface}, and its light reaches nothing outside")
                }
                Within::Eye => format!(
                    "{light} is outside {surface}, which the camera is in, and its light reaches \
                     nothing inside"
                ),
            }
        });
    }
    for (key, what, colour) in colours {
        findings.add(Kind::Colour, || {
            format!(
                "{}: {what} {} looks like 0..255, and 1 is full: divide by 255, or write \
                 srgb(\"#rrggbb\")",
                stage.name_of(key),
                point(colour)
            )
        });
    }
}

/// Lights that are shut in or out, and by what.
fn enclosed(scene: &Scene, sight: Option<Sight<'_>>) -> Vec<(Key, Key, Within)> {
    let (Some(mut sight), Some(eye)) = (sight, eye(scene)) else { return Vec::new() };
    let suns = scene.keys().filter(|key| scene.has::<Sun>(*key)).map(|key| (key, None));
    let lights = nearby::lights(scene).map(|(key, _, at)| (key, Some(at))).chain(suns);
    let lit = lights.filter(|(key, _)| {
        colours::emissivity(scene, *key).is_some_and(|colour| colour != DVec3::ZERO)
    });
    let between = |(key, at)| {
        let (surface, within) = sight.between(at, eye)?;
        Some((key, surface, within))
    };
    lit.filter_map(between).collect()
}

/// Where the camera is.
fn eye(scene: &Scene) -> Option<DVec3> {
    let camera = scene.singletons.camera.and_then(|key| scene.get::<Camera>(key))?;
    Some(match camera {
        Camera::LookAt { eye, .. } | Camera::Parallel { eye, .. } => eye,
        Camera::Window { viewpoint, .. } => viewpoint,
    })
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
        let (value, takes) = (params::setting(&p.value), params::domain(&p.domain));
        let _ = writeln!(text, "parameter   {} = {value}, {takes}", p.name);
    }
    text
}
