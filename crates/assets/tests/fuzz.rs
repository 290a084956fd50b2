//! Broken files of every format: a corpus that is replayed, and random mutations of it.
//!
//! `cargo test` replays the corpus and a few hundred mutations of each file's format.
//! `REFLET_FUZZ=100000 cargo test -p reflet-assets --test fuzz -- --nocapture` makes so many of each;
//! `REFLET_FUZZ_FORMAT=png` takes one format alone, `REFLET_FUZZ_SEED=7` others than usual. A case that
//! fails is written to the folder of temporary files, and belongs into the corpus once it is mended.
//!
//! What must hold: no panic of ours, no message of more than one line, no picture of another size than
//! it says, no number that is not finite, and neither much time nor, by the limits, much memory.

use reflet_assets::picture::{self, Room};
use reflet_assets::shield::shielded;
use reflet_assets::{AssetError, Cause, mesh};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Mutations of each format where nothing else is said.
const CASES: u64 = 400;
/// What a picture may take here: so little that every case is quick.
const ROOM: Room = Room { most: 8 << 20, left: 8 << 20, made: 12 };
/// A case that takes longer is a fault; the slowest machines are ten times faster.
const LONGEST: Duration = Duration::from_secs(20);

/// Random numbers with a seed (xorshift64*, Vigna 2016).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() >> 33) as usize % n.max(1)
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus")
}

/// The files of the corpus by format, which is the name of their folder.
fn corpus() -> Vec<(String, Vec<Vec<u8>>)> {
    let sorted = |path: &Path| {
        let entries = std::fs::read_dir(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        paths
    };
    let format = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, sorted(path).iter().map(|file| std::fs::read(file).unwrap()).collect())
    };
    sorted(&folder()).iter().map(format).collect()
}

/// Numbers at which programs break.
const EDGES: [u32; 10] = [0, 1, 2, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff];

fn mutated(from: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = from[random.below(from.len())].clone();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        let length = 1 + random.below(8);
        match random.below(8) {
            _ if bytes.is_empty() => break,
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.next() as u8,
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..(at + length).min(bytes.len()))),
            4 => {
                let extra: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
                bytes.splice(at..at, extra);
            }
            5 => {
                let piece = bytes[at..(at + 16 * length).min(bytes.len())].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            6 => {
                let other = &from[random.below(from.len())];
                let start = random.below(other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[start.min(other.len())..]);
            }
            _ => {
                let value = EDGES[random.below(EDGES.len())];
                let value = match random.below(2) {
                    0 => value.to_le_bytes(),
                    _ => value.to_be_bytes(),
                };
                let size = [1, 2, 4][random.below(3)].min(bytes.len() - at);
                bytes[at..at + size].copy_from_slice(&value[..size]);
            }
        }
    }
    bytes
}

/// Gives the chunks of a PNG the checks that they should have, so that what they hold is looked at.
fn with_checks(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes(head.try_into().unwrap()) as usize;
        let end = at + 8 + length;
        if end + 4 > bytes.len() {
            return;
        }
        let check = crc32fast::hash(&bytes[at + 4..end]).to_be_bytes();
        bytes[end..end + 4].copy_from_slice(&check);
        at = end + 4;
    }
}

/// What a file comes to: `Ok` or why not.
fn decoded(format: &str, bytes: &[u8]) -> Result<(), String> {
    if matches!(format, "obj" | "ply" | "stl" | "gltf" | "glb" | "mtl") {
        let (name, file) = match format {
            "mtl" => (
                "a.obj".to_owned(),
                &b"mtllib a\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"[..],
            ),
            ending => (format!("a.{ending}"), bytes),
        };
        let missing = reflet_assets::jail::open(Path::new("/nowhere"), "a");
        let mut other = |_: &str| -> Result<Vec<u8>, AssetError> {
            match format {
                "mtl" => Ok(bytes.to_vec()),
                _ => missing.as_ref().map(|_| Vec::new()).map_err(Clone::clone),
            }
        };
        let decode = || mesh::decode(Path::new(&name), file, &mut other);
        let mesh = shielded(decode).map_err(|panic| format!("the file is broken ({panic})"))?;
        let mesh = mesh.map_err(|error| {
            assert!(matches!(error.cause(), Cause::Broken | Cause::Missing | Cause::Forbidden));
            error.to_string()
        })?;
        assert!(mesh.data.positions.iter().flatten().all(|value| value.is_finite()));
        return Ok(());
    }
    let raster = picture::decode(bytes, ROOM).map_err(|fault| fault.message)?;
    let pixels = raster.width as usize * raster.height as usize;
    let count = match &raster.samples {
        picture::Samples::U8(values) => values.len(),
        picture::Samples::U16 { values, most } => {
            assert!(values.iter().all(|value| value <= most));
            values.len()
        }
        picture::Samples::F32(values) => {
            assert!(values.iter().all(|value| value.is_finite()));
            values.len()
        }
    };
    assert_eq!(count, pixels * raster.channels);
    assert!(raster.notes.iter().all(|note| !note.contains(char::is_control)));
    Ok(())
}

/// Whether the file was taken; panics tell which it was.
fn case(format: &str, bytes: &[u8], name: &str) -> Result<(), String> {
    let begun = Instant::now();
    let result = std::panic::catch_unwind(|| decoded(format, bytes)).unwrap_or_else(|_| {
        let path = std::env::temp_dir().join(format!("reflet-fuzz-{format}-{name}"));
        std::fs::write(&path, bytes).unwrap();
        panic!("{format} {name}: see {}", path.display());
    });
    assert!(begun.elapsed() < LONGEST, "{format} {name}: {:?}", begun.elapsed());
    if let Err(message) = &result {
        assert!(!message.contains(char::is_control), "{format} {name}: {message}");
    }
    result
}

fn set(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

#[test]
fn broken_files_end_in_one_message() {
    let number = |name| set(name).map(|text| text.parse::<u64>().expect("a whole number"));
    let cases = number("REFLET_FUZZ").unwrap_or(CASES);
    let seed = number("REFLET_FUZZ_SEED").unwrap_or(1);
    let only = set("REFLET_FUZZ_FORMAT");
    for (format, files) in corpus() {
        if only.as_ref().is_some_and(|only| *only != format) {
            continue;
        }
        for (index, bytes) in files.iter().enumerate() {
            let _ = case(&format, bytes, &format!("corpus-{index}"));
        }
        let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ seed);
        let (mut taken, mut broken) = (0_u64, std::collections::BTreeMap::<String, u64>::new());
        for index in 0..cases {
            let mut bytes = mutated(&files, &mut random);
            if format == "png" && random.below(4) > 0 {
                with_checks(&mut bytes);
            }
            match case(&format, &bytes, &format!("{seed}-{index}")) {
                Ok(()) => taken += 1,
                Err(message) => {
                    let kind: String = message.chars().filter(|c| !c.is_ascii_digit()).collect();
                    *broken.entry(kind).or_default() += 1;
                }
            }
        }
        let panics: u64 =
            broken.iter().filter(|(k, _)| k.contains("is broken (")).map(|(_, n)| n).sum();
        println!("{format}: {cases} cases, {taken} read, {panics} panics of decoders caught");
        if set("REFLET_FUZZ").is_some() {
            for (kind, count) in broken.iter().filter(|(kind, _)| kind.contains("is broken (")) {
                println!("    {count} x {kind}");
            }
        }
    }
}

#[test]
fn every_file_of_the_corpus_is_small() {
    for (format, files) in corpus() {
        assert!(!files.is_empty() && files.iter().all(|file| file.len() <= 4096), "{format}");
    }
}
