//! A frame that builds on the frame before is, bit for bit, the frame made from scratch: random
//! scenes under random edits, over threads, tile sizes, memory budgets, and SIMD levels.

mod edits;

use edits::{Dice, EDITS, edit, stage};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use proptest::{arbitrary::any, collection, strategy::Strategy};
use reflet_accel::{Isa, Structure};
use reflet_film::{Layout, Picture, SampleKind, Transfer, TransferTable};
use reflet_frame::engine::Work;
use reflet_frame::{Batch, Engine, EngineOptions, Reuse};
use reflet_pack::{Changes, Columns, MaterialChange, SceneHasher, Volume};
use reflet_scene::{Image, Spread};
use reflet_trace::BatchColours;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

fn engine(dice: &mut Dice, reuse: Reuse) -> Engine {
    let isas: Vec<Isa> = Isa::available().collect();
    Engine::new(EngineOptions {
        threads: NonZeroUsize::new([1, 2, 3, 16][dice.below(4)]),
        isa: isas[dice.below(isas.len())],
        tile: [4, 8, 16, 64][dice.below(4)],
        structure: [Structure::Auto, Structure::List, Structure::Tree][dice.below(3)],
        reuse,
        cache_bytes: [0, 20_000, u64::MAX, u64::MAX][dice.below(4)],
        ..EngineOptions::default()
    })
    .expect("an engine")
}

fn bits(picture: &Picture) -> Vec<u32> {
    let layout = picture.layout();
    let mut row = vec![0.0f32; layout.width() as usize * 3];
    let mut bits = Vec::new();
    for y in 0..layout.height() {
        picture.row(y, &mut row);
        bits.extend(row.iter().map(|x| x.to_bits()));
    }
    bits
}

/// Renders a batch into float pictures.
fn render(
    engine: &mut Engine,
    columns: &Columns,
    changes: Option<&Changes>,
    colours: &BatchColours,
    last: Option<&Picture>,
) -> (Vec<Picture>, Work) {
    let [w, h] = columns.view.size;
    let layout = Layout::try_new(w, h, engine.grid(columns).edge).expect("a layout");
    let table = TransferTable::new(Transfer::Srgb, SampleKind::F32);
    let picture = || Picture::try_new(layout, SampleKind::F32).expect("memory");
    let mut pictures: Vec<Picture> = (0..colours.len()).map(|_| picture()).collect();
    // Tiles are the same size as before unless the number of bounces asks for smaller ones.
    let last = last.filter(|p| p.layout() == layout);
    let batch = Batch { columns, changes, colours, table: &table, last };
    let cancel = AtomicBool::new(false);
    let work = engine.render(batch, &mut pictures, &cancel).expect("no one stops it");
    (pictures, work)
}

/// Renders one frame.
fn still(engine: &mut Engine, columns: &Columns, changes: Option<&Changes>) -> (Picture, Work) {
    let (mut pictures, work) = render(engine, columns, changes, &BatchColours::of(columns), None);
    (pictures.remove(0), work)
}

/// Frames that share their trees, as the frame loop gathers them, and what each must look like.
#[derive(Default)]
struct Pending {
    changes: Option<Changes>,
    colours: BatchColours,
    wanted: Vec<(Vec<u32>, String)>,
}

impl Pending {
    /// Renders all and compares; gives the last picture, or says which frame differs.
    fn hold(
        self,
        engine: &mut Engine,
        columns: &Columns,
        last: Option<Picture>,
    ) -> Result<Option<Picture>, String> {
        if self.wanted.is_empty() {
            return Ok(last);
        }
        let last = last.as_ref();
        let (mut pictures, work) =
            render(engine, columns, self.changes.as_ref(), &self.colours, last);
        let counted = work.counts.closest + work.counts.any;
        assert_eq!(work.rays.total(), counted, "rays as trace and accel count them");
        for (picture, (want, which)) in pictures.iter().zip(&self.wanted) {
            let differ = bits(picture).iter().zip(want).filter(|(a, b)| a != b).count();
            if differ > 0 {
                return Err(format!("{differ} samples differ: {which}"));
            }
        }
        Ok(pictures.pop())
    }
}

/// What is done to the changes that the warm engine is told of.
type Tamper = fn(&mut Changes);

/// Plays a random scene under edits and says which warm frame is not the cold one, if any.
fn play(seed: u64, frames: &[Vec<Edit>], tamper: Tamper) -> Result<(), String> {
    let mut dice = Dice(seed);
    let mut stage = stage(&mut dice);
    let mut warm = engine(&mut dice, Reuse::Keep);
    let longest = [1, 2, 16][dice.below(3)];
    let samples = 2 + dice.below(2) as u32;
    let adaptive = (dice.below(3) == 0).then_some((samples, Spread::Edges));
    let mut before = stage.packer.columns().clone();
    let mut hasher = SceneHasher::default();
    let (mut pending, mut last) = (Pending::default(), None);
    for (frame, edits) in std::iter::once(&Vec::new()).chain(frames).enumerate() {
        stage.scene.rewind();
        if let Some((samples, spread)) = adaptive {
            let key = stage.scene.singletons.image.expect("an image");
            stage.scene.set(key, Image { samples, spread, ..stage.scene.image() });
        }
        for (kind, seed) in edits {
            edit(*kind, &mut stage, &mut Dice(*seed));
        }
        let which = format!("seed {seed} frame {frame} {edits:?}");
        let joins = stage.packer.only_recolours(&stage.scene);
        let mut changes = stage.packer.update(&stage.scene);
        let columns = stage.packer.columns().clone();
        if !changes.rebuilt {
            assert_eq!(changes, Changes::between(&before, &columns), "{which}");
        }
        let name = hasher.hash(&columns, &changes);
        assert_eq!(name, SceneHasher::of(&columns), "{which}");
        tamper(&mut changes);
        if !joins || pending.colours.len() >= longest {
            last = std::mem::take(&mut pending).hold(&mut warm, &before, last)?;
        }
        if pending.wanted.is_empty() {
            pending.changes = (frame > 0).then(|| changes.clone());
        }
        pending.colours.push(&columns, &changes);
        let mut cold = engine(&mut dice, Reuse::Never);
        pending.wanted.push((bits(&still(&mut cold, &columns, None).0), which));
        before = columns;
    }
    pending.hold(&mut warm, &before, last).map(|_| ())
}

/// A kind of edit, and what its numbers are drawn from.
type Edit = (usize, u64);

/// Frames that each have some edits of the kinds in `kinds`.
fn frames(kinds: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Vec<Edit>>> {
    collection::vec(collection::vec((kinds, any::<u64>()), 0..4), 1..7)
}

/// Plays `cases` random scenes under random edits; a failure is shrunk to the fewest frames and
/// edits that still fail. The same cases at every run.
fn hold(cases: u32, kinds: std::ops::Range<usize>) {
    let config =
        Config { cases, max_shrink_iters: 300, failure_persistence: None, ..Config::default() };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let runner = &mut TestRunner::new_with_rng(config, rng);
    let scenes = any::<u64>().no_shrink();
    let held = runner.run(&(scenes, frames(kinds)), |(seed, frames)| {
        play(seed, &frames, |_| {}).map_err(TestCaseError::fail)
    });
    held.unwrap_or_else(|failure| panic!("{failure}"));
}

#[test]
fn each_kind_of_edit_alone() {
    for kind in 0..EDITS {
        hold(4, kind..kind + 1);
    }
}

#[test]
fn edits_mixed() {
    hold(150, 0..EDITS);
}

/// What a frame costs after one edit: rays by kind, and whether any tree was made from its root.
fn cost(seed: u64, edit_kind: usize) -> (Work, Work) {
    let mut dice = Dice(seed);
    let mut stage = stage(&mut dice);
    let mut engine = Engine::new(EngineOptions::default()).expect("an engine");
    let (_, first) = still(&mut engine, stage.packer.columns(), None);
    edit(edit_kind, &mut stage, &mut dice);
    let changes = stage.packer.update(&stage.scene);
    let (_, second) = still(&mut engine, stage.packer.columns(), Some(&changes));
    (first, second)
}

#[test]
fn only_what_can_differ_is_cast_again() {
    for seed in 0..8 {
        for colours_only in [1, 2, 12] {
            let (first, second) = cost(seed, colours_only);
            assert!(first.rays.camera > 0);
            assert_eq!(second.rays.total(), 0, "edit {colours_only} casts no ray");
            assert_eq!(second.retraced_pixels, 0);
        }
        let (first, second) = cost(seed, 3);
        assert_eq!((second.rays.camera, second.rays.mirror), (0, 0), "a moved light");
        assert!(second.rays.shadow < first.rays.shadow, "casts its own shadows only");
        let (_, second) = cost(seed, 16);
        assert_eq!(second.rays.camera, 0, "swapped cells cast mirrored rays at most");
        let (first, second) = cost(seed, 5);
        assert!(second.rays.camera < first.rays.camera, "one moved ball does not touch all");
        assert_eq!(second.retraced_pixels, second.rays.camera);
    }
}

/// A seed far from that of its neighbours, whose first numbers would follow its own by a fixed step.
fn scattered(seed: u64) -> u64 {
    let mixed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9)
}

/// The tests of this file see every part of the comparison: with any one of them left out or made
/// too small, some warm frame is not the cold one.
#[test]
fn each_comparison_is_needed() {
    fn each_volume(changes: &mut Changes, f: fn(&mut Volume, &mut Volume)) {
        changes.surfaces.iter_mut().for_each(|c| f(&mut c.old, &mut c.new));
    }
    fn shrink(volume: &mut Volume) {
        match volume {
            Volume::Nothing => {}
            Volume::Ball { radius, .. } => *radius *= 0.8,
            Volume::Box(bounds) => {
                for k in 0..3 {
                    let shrunk = (bounds.hi[k] - bounds.lo[k]) * 0.2;
                    bounds.lo[k] += shrunk;
                    bounds.hi[k] -= shrunk;
                }
            }
        }
    }
    // The comparison left out, and the edit that needs it.
    let left_out: [(&str, usize, Tamper); 16] = [
        ("materials", 1, |c| c.materials.clear()),
        ("woken materials", 0, |c| c.woken.clear()),
        ("materials that no longer reflect", 0, |c| {
            // Their colours are told, but not that they reflected before.
            let ceased = |m: &&mut MaterialChange| m.new.is_some_and(|row| !row.is_specular());
            c.materials.iter_mut().filter(ceased).for_each(|m| m.old = m.new);
        }),
        ("repainted surfaces", 8, |c| c.repainted.clear()),
        ("pattern cells", 9, |c| c.patterns.clear()),
        ("surfaces", 5, |c| c.surfaces.clear()),
        ("where a surface was", 5, |c| each_volume(c, |old, _| *old = Volume::Nothing)),
        ("where a surface is", 5, |c| each_volume(c, |_, new| *new = Volume::Nothing)),
        ("all of a new ball", 5, |c| each_volume(c, |_, new| shrink(new))),
        ("all of a new box", 10, |c| each_volume(c, |_, new| shrink(new))),
        ("intensities of lights", 2, |c| c.lights.clear()),
        ("places of lights", 3, |c| c.lights.clear()),
        ("settings", 12, |c| c.model = false),
        ("samples", 13, |c| c.samples = false),
        ("the filter", 13, |c| c.view = false),
        ("the camera", 15, |c| c.view = false),
    ];
    for (what, kind, tamper) in left_out {
        let caught = (0..60).any(|seed| {
            let frames: Vec<Vec<Edit>> =
                (0..6).map(|i| vec![(kind, scattered(seed * 7 + i))]).collect();
            play(seed, &frames, tamper).is_err()
        });
        assert!(caught, "no frame differs without the comparison of {what}");
    }
}

/// Kept trees stay within their memory, also when they grow by points or levels.
#[test]
fn trees_stay_within_their_memory() {
    for seed in 0..8 {
        let mut dice = Dice(seed);
        let mut stage = stage(&mut dice);
        let measured = Engine::new(EngineOptions::default());
        let (_, all) = still(&mut measured.expect("an engine"), stage.packer.columns(), None);
        let cache_bytes = all.kept_bytes + all.kept_bytes / 16;
        let options = EngineOptions { cache_bytes, tile: 8, ..EngineOptions::default() };
        let mut engine = Engine::new(options).expect("an engine");
        still(&mut engine, stage.packer.columns(), None);
        for kind in [5, 0, 11, 5, 6, 3] {
            stage.scene.rewind();
            edit(kind, &mut stage, &mut dice);
            let changes = stage.packer.update(&stage.scene);
            let (_, work) = still(&mut engine, stage.packer.columns(), Some(&changes));
            assert!(work.kept_bytes <= cache_bytes, "{} of {cache_bytes}", work.kept_bytes);
        }
    }
}
