//! `reflet profile`: how fast rays are, by the CPU clock of the threads that trace them.
//!
//! | room | holds |
//! | --- | --- |
//! | [`npy`] | NumPy's array files |
//! | [`inputs`] | primitives and rays from files |
//! | [`cast`] | rays cast at primitives |
//! | [`mod@scene`] | one frame of a scene |
//! | [`passes`] | the two passes of a frame |
//! | [`counted`] | what rays take, counted |
//! | [`renderer`] | whole frames, without a file |
//! | [`encode`] | a picture to a file in memory |
//! | [`counters`] | what the processor counts |
//! | [`reuse`] | what the frame before saves |
//! | [`dump`] | a scene's primitives and rays as files |
//! | [`heatmap`] | what each pixel costs, as a picture |
//! | [`timeline`] | stages and tiles on their threads |
//! | [`figures`] | figures kept, and compared |
//! | [`report`] | what is told |

pub mod cast;
pub mod counted;
pub mod counters;
pub mod dump;
pub mod encode;
pub mod figures;
pub mod heatmap;
pub mod inputs;
pub mod npy;
pub mod passes;
pub mod renderer;
mod report;
pub mod reuse;
pub mod scene;
pub mod timeline;

use crate::console::{Console, print};
use crate::exit::{Exit, Failure};
use crate::meant::{Script, Tell};
use cast::Question;
use figures::{About, Comparison, Figure, Record};
use inputs::Primitives;
use reflet_accel::{Accel, Isa, Quality, Rays, Structure};
use reflet_film::SafeFile;
use reflet_frame::Inputs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What is measured.
pub enum Subject {
    /// Rays from a file, cast at primitives from files.
    Files {
        /// The primitives.
        primitives: Primitives,
        /// The rays.
        rays: PathBuf,
        /// What is asked of them.
        question: Question,
        /// Where the answers go.
        hits: Option<PathBuf>,
    },
    /// A frame of a scene.
    Scene(Script, u32, Outputs),
}

/// What of a scene is written beside the measurement, at the first of the levels and numbers of
/// threads.
pub struct Outputs {
    /// The folder that primitives and rays go to.
    pub dump: Option<PathBuf>,
    /// A picture of what each pixel costs.
    pub heatmap: Option<PathBuf>,
    /// A timeline.
    pub timeline: Option<PathBuf>,
}

/// What is measured, and how.
pub struct Profile {
    /// What is measured.
    pub subject: Subject,
    /// Which levels.
    pub isas: Vec<Isa>,
    /// How many threads, one measurement each.
    pub threads: Vec<usize>,
    /// How often.
    pub repeat: usize,
    /// How good a tree is built.
    pub quality: Quality,
    /// Where figures are kept.
    pub save: Option<PathBuf>,
    /// Figures of an earlier run.
    pub against: Option<PathBuf>,
    /// Whom the result is told to.
    pub tell: Tell,
}

/// Measures, and tells what was measured.
///
/// # Errors
/// Inputs that cannot be read, an output that cannot be written, levels that this machine lacks.
pub fn run(profile: &Profile) -> Result<(), Failure> {
    profile.spare(&[])?;
    let before = profile.against.as_deref().map(figures::read).transpose()?;
    let mut book = Book { before, about: None, now: Vec::new() };
    match &profile.subject {
        Subject::Files { primitives, rays, question, hits } => {
            files(profile, primitives, rays, *question, hits.as_ref(), &mut book)?;
        }
        Subject::Scene(script, frame, outputs) => {
            scene(profile, script, *frame, outputs, &mut book)?;
        }
    }
    if let (Some(before), Tell::People) = (&book.before, profile.tell) {
        print(figures::table(&figures::compare(&book.now, &before.figures)))?;
    }
    match (&profile.save, book.about) {
        (Some(path), Some(about)) => figures::write(path, &Record { about, figures: book.now }),
        _ => Ok(()),
    }
}

/// Figures of now, and of an earlier run.
struct Book {
    before: Option<Record>,
    about: Option<About>,
    now: Vec<Figure>,
}

impl Book {
    /// Holds what is about to be measured against what was, before anything is.
    fn open(&mut self, profile: &Profile, about: About) -> Result<(), Failure> {
        if let (Some(before), Some(path)) = (&self.before, &profile.against) {
            let levels = profile.isas.iter().map(|isa| isa.resolved().name());
            let ways: Vec<_> = levels
                .flat_map(|isa| profile.threads.iter().map(move |threads| (isa, *threads)))
                .collect();
            before.fits(path, &about, &ways)?;
        }
        self.about = Some(about);
        Ok(())
    }

    /// Takes figures, and holds them against those of before, if there are any.
    fn enter(&mut self, figures: Vec<Figure>) -> Option<Vec<Comparison>> {
        let before = self.before.as_ref();
        let compared = before.map(|before| figures::compare(&figures, &before.figures));
        self.now.extend(figures);
        compared
    }
}

impl Profile {
    /// Refuses outputs that are an input, `more` among them, or one another.
    fn spare(&self, more: &[PathBuf]) -> Result<(), Failure> {
        let mut inputs: Vec<&Path> = more.iter().map(PathBuf::as_path).collect();
        inputs.extend(self.against.as_deref());
        let mut outputs: Vec<&Path> = self.save.iter().map(PathBuf::as_path).collect();
        match &self.subject {
            Subject::Files { primitives, rays, hits, .. } => {
                inputs.push(rays);
                inputs.extend(primitives.files());
                outputs.extend(hits.as_deref());
            }
            Subject::Scene(script, _, of_scene) => {
                inputs.push(&script.path);
                let Outputs { dump, heatmap, timeline } = of_scene;
                outputs.extend([dump, heatmap, timeline].into_iter().filter_map(Option::as_deref));
            }
        }
        let refused = |why: String| Failure::new(Exit::Output, why);
        let inputs = Inputs::of(inputs);
        for (i, output) in outputs.iter().enumerate() {
            inputs.spare(output).map_err(|refusal| refused(refusal.to_string()))?;
            if outputs[..i].contains(output) {
                let output = output.display();
                return Err(refused(format!("{output} is named for two outputs: name another")));
            }
        }
        Ok(())
    }

    fn each(&self, mut run: impl FnMut(Isa, usize) -> Result<(), Failure>) -> Result<(), Failure> {
        self.isas
            .iter()
            .try_for_each(|isa| self.threads.iter().try_for_each(|threads| run(*isa, *threads)))
    }
}

fn scene(
    profile: &Profile,
    script: &Script,
    frame: u32,
    outputs: &Outputs,
    book: &mut Book,
) -> Result<(), Failure> {
    let frame = scene::load(script, frame, profile.quality)?;
    profile.spare(&frame.inputs)?;
    let about = About::new("a frame of a scene", frame.name(), profile.quality);
    book.open(profile, about)?;
    if let (Some(isa), Some(threads)) = (profile.isas.first(), profile.threads.first()) {
        let name = script.path.file_stem().unwrap_or_default().to_string_lossy();
        let text = frame.write(outputs, &name, *isa, *threads)?;
        match profile.tell {
            Tell::People | Tell::Scheduler => print(text)?,
            // Stdout holds objects only.
            Tell::Programs if !text.is_empty() => Console::new().say(text.trim_end()),
            Tell::Programs => {}
        }
    }
    if profile.tell == Tell::People {
        print(report::stages(&frame))?;
    }
    profile.each(|isa, threads| {
        let measured = frame.measure(isa, threads, profile.repeat)?;
        let compared = book.enter(measured.figures());
        print(match profile.tell {
            Tell::Programs => {
                report::line(report::scene_object(&frame, &measured), compared.as_deref())
            }
            Tell::People | Tell::Scheduler => report::scene_table(&frame, &measured),
        })
    })
}

fn files(
    profile: &Profile,
    primitives: &Primitives,
    rays: &Path,
    question: Question,
    hits: Option<&PathBuf>,
    book: &mut Book,
) -> Result<(), Failure> {
    let mut digest = inputs::Digest::default();
    let geometry = primitives.read(&mut digest)?;
    let most = profile.threads.iter().max().copied().unwrap_or(1);
    // Alone, a thread takes all rays as one stream; several share out parts.
    let parts = if most == 1 { 1 } else { 8 * most };
    let streams = inputs::rays(rays, parts, &mut digest)?;
    let subject = match question {
        Question::Closest => "rays from a file",
        Question::Any => "rays from a file, --any",
    };
    book.open(profile, About::new(subject, digest.name(), profile.quality))?;
    if profile.tell == Tell::People {
        print(report::FILES_HEAD)?;
    }
    profile.each(|isa, threads| {
        let level = isa.level().map_err(|e| Failure::usage(format!("--isa: {e}")))?;
        let pool = cast::pool(threads)?;
        let start = Instant::now();
        let accel = {
            let build = || Accel::build_as(&geometry, level, Structure::Auto, profile.quality);
            pool.install(build)
        };
        let build = start.elapsed();
        let done = cast::cast(&accel, &pool, &streams, question, profile.repeat);
        let count: usize = streams.iter().map(Rays::len).sum();
        if let Some(path) = hits {
            let descr = "[('t', '<f4'), ('prim', '<u4')]";
            npy::write(path, descr, &format!("({count},)"), &done.rows(&streams))?;
        }
        let line = report::Line {
            rays: count,
            hits: done.hits(&streams),
            isa: isa.resolved().name(),
            threads,
            repeat: profile.repeat,
            build_ms: build.as_secs_f64() * 1e3,
            primitives: geometry.prims() as usize,
            bytes_per_primitive: accel.bytes() as f64 / geometry.prims().max(1) as f64,
            sah_cost: accel.sah_cost(),
            hardware_per_ray: counters::count(&accel, &streams, question).json(count),
            ..report::Line::of(count, &done)
        };
        let figure =
            Figure::new("rays", (isa.resolved().name(), threads), &done.cpu, &done.reference);
        let compared = book.enter(vec![figure]);
        print(match profile.tell {
            Tell::Programs => report::line(&line, compared.as_deref()),
            Tell::People | Tell::Scheduler => report::files_row(&line),
        })
    })
}

/// Writes a file; missing folders are made.
fn put(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let write = || {
        let mut file = SafeFile::create(path)?;
        file.write_all(bytes)?;
        file.commit()
    };
    // The error names the file.
    write().map_err(|e: std::io::Error| Failure::new(Exit::Output, e.to_string()))
}
