//! Parts whose texts are not what a render writes: merged, or refused in words.

use reflet_film::{
    Compression, Format, Layout, Picture, SampleKind, StillOptions, Target, encode_sealed,
};
use reflet_frame::provenance::SOFTWARE;
use reflet_frame::{MergeError, merge};
use std::path::PathBuf;

/// An EXR of 4 x 3 pixels that is sealed with these texts, as whoever knows the format can.
fn part(settings: &str, tile: &str) -> Vec<u8> {
    let layout = Layout::try_new(4, 3, 16).unwrap();
    let picture = Picture::try_new(layout, SampleKind::F32).unwrap();
    let text = [
        ("Software", SOFTWARE),
        ("reflet-scene", "0"),
        ("reflet-settings", settings),
        ("reflet-tile", tile),
    ];
    let options = StillOptions { text: &text, ..StillOptions::default() };
    encode_sealed(&picture, Format::Exr, &options, None).unwrap().encoded.to_vec()
}

const SETTINGS: &str = "frame=0 size=8x3 samples=1 format=exr compression=fast";
const TILES: [&str; 2] =
    ["x=0 y=0 width=4 height=3 transfer=srgb", "x=4 y=0 width=4 height=3 transfer=srgb"];

fn merged(parts: [Vec<u8>; 2]) -> Result<[u32; 2], MergeError> {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = ["a.exr", "b.exr"].map(|name| folder.path().join(name)).to_vec();
    paths.iter().zip(parts).for_each(|(path, part)| std::fs::write(path, part).unwrap());
    let target = Target::parse(folder.path().join("o.png").as_os_str(), None, 1).unwrap();
    merge(&paths, &target, Compression::Fast).map(|merged| merged.size)
}

#[test]
fn mutated_texts_are_merged_or_refused() {
    assert_eq!(merged(TILES.map(|tile| part(SETTINGS, tile))).unwrap(), [8, 3]);
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut dice = move |sides: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % sides as u64) as usize
    };
    let numbers =
        ["", "-1", "0", "1", "65535", "65536", "4294967295", "4294967296", "x", "1e9", " "];
    let mut mutated = |text: &str| {
        let mut words: Vec<String> = text.split(' ').map(str::to_owned).collect();
        for _ in 0..=dice(3) {
            let at = dice(words.len());
            match dice(5) {
                0 => drop(words.remove(at)),
                1 => words.push(words[at].clone()),
                2 => words.swap(at, 0),
                3 => words[at] = numbers[dice(numbers.len())].to_owned(),
                _ => {
                    let number = numbers[dice(numbers.len())];
                    let key = words[at].split('=').next().unwrap_or_default().to_owned();
                    words[at] = match key.as_str() {
                        "size" => format!("size={number}x{}", numbers[dice(numbers.len())]),
                        key => format!("{key}={number}"),
                    };
                }
            }
            if words.is_empty() {
                words.push(String::new());
            }
        }
        words.join(" ")
    };
    let mut refused = 0;
    for _ in 0..400 {
        let settings = mutated(SETTINGS);
        let parts = TILES.map(|tile| part(&settings, &mutated(tile)));
        refused += usize::from(merged(parts).is_err());
    }
    assert!(refused > 300, "{refused}");
}
