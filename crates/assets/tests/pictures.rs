//! Pictures of every format that other programs have written, against what those read from them.

use reflet_assets::picture::{self, Curve, Raster, Room, Samples};
use reflet_assets::texture::{self, Encoding};
use std::path::Path;
use std::process::Command;

const ROOM: Room = Room { most: 1 << 26, left: 1 << 26, made: 12 };

/// Writes each kind, and beside it what Pillow reads: `NAME.rgb`, and `list` of names with tolerances.
const PILLOW: &str = "
from PIL import Image, PngImagePlugin
import struct
w, h = 41, 23
rgb = Image.new('RGB', (w, h))
rgb.putdata([(i % w * 6, i // w * 10, (i * 7) % 200) for i in range(w * h)])
smooth = Image.new('RGB', (w, h))
smooth.putdata([(i % w * 5, i // w * 9, 99) for i in range(w * h)])
rgba = rgb.copy(); rgba.putalpha(Image.linear_gradient('L').resize((w, h)))
grey, bits, few = rgb.convert('L'), rgb.convert('1'), rgb.quantize(16)
listed = open('list', 'w')
def save(name, image, tolerance=0, **how):
    image.save(name, **how)
    read = Image.open(name)
    open(name + '.rgb', 'wb').write(read.convert('RGB').tobytes())
    print(name, tolerance, file=listed)
for kind, image in dict(rgb=rgb, rgba=rgba, grey=grey, la=rgba.convert('LA'), bits=bits, p=rgb.quantize(256)).items():
    save(kind + '.png', image)
for depth in 1, 2, 4, 8:
    save(f'p{depth}.png', rgb.quantize(1 << depth), bits=depth)
clear = rgb.quantize(16)
save('trns.png', clear, transparency=bytes([0, 128]))
save('rgbtrns.png', rgb, transparency=(0, 0, 0))
for n in 0, 1, 2:
    save(f's{n}.jpg', smooth, 6, quality=95, subsampling=n)
save('grey.jpg', grey, 3, quality=95)
save('progressive.jpg', smooth, 6, quality=95, progressive=True)
save('restart.jpg', smooth, 6, quality=90, restart_marker_blocks=2)
save('optimized.jpg', smooth, 6, quality=70, optimize=True)
save('rgb.webp', rgb, lossless=True)
save('rgba.webp', rgba, lossless=True, exact=True)
save('lossy.webp', smooth, 3, quality=90)
for kind, image in dict(rgb=rgb, rgba=rgba, grey=grey, bits=bits).items():
    for coding in None, 'tiff_lzw', 'tiff_adobe_deflate', 'packbits':
        save(f'{kind}-{coding}.tif', image, compression=coding)
for kind, image in dict(rgb=rgb, grey=grey, bits=bits, p=few).items():
    save(kind + '.bmp', image)
for kind, image in dict(rgb=rgb, rgba=rgba, grey=grey, p=few).items():
    save(kind + '.tga', image)
    save(kind + '-rle.tga', image, compression='tga_rle')
save('rgb.ppm', rgb)
save('grey.pgm', grey)
save('bits.pbm', bits)
try:
    save('rgb.qoi', rgb)
    save('rgba.qoi', rgba)
except (KeyError, ValueError, OSError):
    pass
listed.close()
smooth.convert('CMYK').save('cmyk.jpg', quality=95)
Image.linear_gradient('L').resize((w, h)).convert('I;16').point(lambda v: v * 200).save('wide.png')
turned = Image.new('RGB', (16, 32)); turned.paste((255, 0, 0), (0, 0, 16, 16))
for n in range(1, 9):
    exif = Image.Exif(); exif[0x0112] = n
    turned.save(f'turned{n}.jpg', quality=95, exif=exif)
    from PIL import ImageOps
    upright = ImageOps.exif_transpose(Image.open(f'turned{n}.jpg'))
    open(f'turned{n}.rgb', 'wb').write(struct.pack('<2I', *upright.size) + upright.tobytes())
def chunk(name, data, image=grey):
    info = PngImagePlugin.PngInfo(); info.add(name[:4].encode(), data); image.save(name + '.png', pnginfo=info)
chunk('gAMA-linear', struct.pack('>I', 100000))
chunk('gAMA-srgb', struct.pack('>I', 45455))
chunk('gAMA-half', struct.pack('>I', 50000))
chunk('cICP-linear', bytes([1, 8, 0, 1]))
chunk('cICP-pq', bytes([9, 16, 0, 1]))
chunk('sRGB-', bytes([0]))
rgb.copy().save('two.tif', save_all=True, append_images=[grey.copy()])
rgb.copy().save('moving.png', save_all=True, append_images=[grey.convert('RGB')])
rgb.copy().save('moving.webp', save_all=True, append_images=[grey.convert('RGB')], lossless=True)
";

/// Whether Python could do it; if it may not be skipped, it must.
fn made(script: &str, folder: &Path) -> bool {
    let python = Command::new("python3").args(["-c", script]).current_dir(folder).output();
    let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
    let done = match &python {
        Ok(ran) if ran.status.success() => true,
        Ok(ran) => {
            let said = String::from_utf8_lossy(&ran.stderr);
            assert!(said.contains("No module named 'PIL'") && !required, "{said}");
            false
        }
        Err(error) => {
            assert!(!required, "Python is not there: {error}");
            false
        }
    };
    if !done {
        println!("skipped: Pillow is not there");
    }
    done
}

fn read(folder: &Path, name: &str) -> Raster {
    let bytes = std::fs::read(folder.join(name)).unwrap();
    picture::decode(&bytes, ROOM).unwrap_or_else(|fault| panic!("{name}: {}", fault.message))
}

/// Red, green and blue of a picture of 8 bits.
fn rgb(raster: &Raster) -> Vec<u8> {
    let values: Vec<u8> = match &raster.samples {
        Samples::U8(values) => values.clone(),
        Samples::U16 { values, most: 1 } => values.iter().map(|v| *v as u8 * 255).collect(),
        other => panic!("{other:?}"),
    };
    let pixel = |p: &[u8]| if p.len() > 2 { [p[0], p[1], p[2]] } else { [p[0]; 3] };
    values.chunks_exact(raster.channels).flat_map(pixel).collect()
}

#[test]
fn every_kind_is_what_pillow_reads() {
    let room = tempfile::tempdir().unwrap();
    let folder = room.path();
    if !made(PILLOW, folder) {
        return;
    }
    let list = std::fs::read_to_string(folder.join("list")).unwrap();
    assert!(list.lines().count() > 40);
    for (name, tolerance) in list.lines().filter_map(|line| line.split_once(' ')) {
        // Lossy files by two decoders: the inverse transform may round otherwise, and chroma is
        // interpolated in another way.
        let tolerance: u8 = tolerance.parse().unwrap();
        let raster = read(folder, name);
        assert_eq!((raster.width, raster.height), (41, 23), "{name}");
        let want = std::fs::read(folder.join(format!("{name}.rgb"))).unwrap();
        let found = rgb(&raster);
        assert_eq!(found.len(), want.len(), "{name}");
        let far = found.iter().zip(&want).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(far <= tolerance, "{name}: {far}");
    }
    let wide = read(folder, "wide.png");
    assert!(matches!(wide.samples, Samples::U16 { most: 65_535, .. }));
    // Inks without a profile: white stays white, and the rest is near (Pillow inverts them plainly).
    let cmyk = rgb(&read(folder, "cmyk.jpg"));
    let smooth = rgb(&read(folder, "s0.jpg"));
    let far = cmyk.iter().zip(&smooth).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(far <= 6, "{far}");
    for n in 1..=8 {
        let turned = std::fs::read(folder.join(format!("turned{n}.jpg"))).unwrap();
        let texture = texture::decode(&turned).unwrap();
        let want = std::fs::read(folder.join(format!("turned{n}.rgb"))).unwrap();
        let size = want.as_chunks::<4>().0.iter().map(|four| u32::from_le_bytes(*four));
        assert!(size.take(2).eq([texture.width, texture.height]), "{n}");
        for (texel, pixel) in texture.texels.iter().zip(want[8..].as_chunks::<3>().0) {
            assert_eq!(texel[0] > 0.5, pixel[0] > 127, "{n}");
        }
        // glTF has pictures taken as they are stored.
        let stored = texture::read(&turned, Encoding::Srgb).unwrap();
        assert_eq!((stored.texture.width, stored.texture.height), (16, 32));
    }
    for (name, note) in [
        ("moving.png", "it is an animation: its first picture alone is read"),
        ("moving.webp", "it is an animation: its first picture alone is read"),
        ("two.tif", "it holds more pictures than one: the first is read"),
    ] {
        assert_eq!(read(folder, name).notes, [note], "{name}");
    }
    let bytes = std::fs::read(folder.join("rgba.png")).unwrap();
    let told = texture::read(&bytes, Encoding::Told).unwrap();
    assert!(told.transparent);
    assert_eq!(told.notes, ["its transparency is left out"]);
    curves(folder);
}

/// What a PNG says of its samples.
fn curves(folder: &Path) {
    let curve = |name: &str| read(folder, &format!("{name}.png")).curve;
    assert_eq!(curve("gAMA-linear"), Curve::Linear);
    assert_eq!(curve("gAMA-srgb"), Curve::Srgb);
    assert_eq!(curve("gAMA-half"), Curve::Power(2.0));
    assert_eq!(curve("cICP-linear"), Curve::Linear);
    assert_eq!(curve("sRGB-"), Curve::Srgb);
    let pq = std::fs::read(folder.join("cICP-pq.png")).unwrap();
    let fault = texture::decode(&pq).unwrap_err();
    assert!(fault.message.contains("PQ"), "{}", fault.message);
    let bytes = std::fs::read(folder.join("gAMA-half.png")).unwrap();
    let values = rgb(&read(folder, "gAMA-half.png"));
    let sample = f64::from(values[3 * 100]) / 255.0;
    let at = |encoding| texture::read(&bytes, encoding).unwrap().texture.texels[100][0];
    assert_eq!(at(Encoding::Told), (sample * sample) as f32);
    assert_eq!(at(Encoding::Linear), sample as f32);
    assert!((f64::from(at(Encoding::Srgb)) - ((sample + 0.055) / 1.055).powf(2.4)).abs() < 1e-7);
}
