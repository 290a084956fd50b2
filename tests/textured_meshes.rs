//! Meshes that wear the textures of their glTF file, held against the model in f64.

mod oracle;

use oracle::binary::{folder, render};
use oracle::texture::decoded;
use oracle::vec3::{Vec3, v3};
use oracle::view::Picture;
use std::path::Path;

/// Texels along an edge of each texture.
const TEXELS: usize = 4;

/// The texels of texture `which`, from the top.
fn texels(which: usize) -> Vec<[u8; 3]> {
    let number =
        |i: usize, k: usize| (31 * (i + 1) * (k + 2) + 97 * which * (i + 3) + 13 * k) % 256;
    (0..TEXELS * TEXELS).map(|i| [0, 1, 2].map(|k| number(i, k) as u8)).collect()
}

fn png(path: &Path, texels: &[[u8; 3]]) {
    let file = std::fs::File::create(path).expect("a file for a texture");
    let mut encoder = png::Encoder::new(file, TEXELS as u32, TEXELS as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(texels.as_flattened()).expect("texels");
}

/// A square from (-1, -1, 0) to (1, 1, 0) that wears three textures: base colour, metalness and
/// roughness, emission; each repeated twice by its transform. Colours at the corners go from white at
/// the left to (1, 0.5, 0.25) at the right.
fn write(folder: &Path, nearest: bool) {
    for which in 0..3 {
        png(&folder.join(format!("{which}.png")), &texels(which));
    }
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0_f32]];
    let mut bytes: Vec<u8> = Vec::new();
    let mut put = |values: &[f32]| values.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    corners.iter().for_each(|[x, y]| put(&[*x, *y, 0.0]));
    corners.iter().for_each(|[x, y]| put(&[(x + 1.0) / 2.0, (1.0 - y) / 2.0]));
    corners.iter().for_each(|[x, _]| {
        put(&if *x < 0.0 { [1.0; 3] } else { [1.0, 0.5, 0.25] });
    });
    bytes.extend([0, 1, 2, 0, 2, 3]);
    std::fs::write(folder.join("square.bin"), &bytes).expect("a buffer");
    let texture = |which: usize| {
        format!(r#"{{"index":{which},"extensions":{{"KHR_texture_transform":{{"scale":[2,2]}}}}}}"#)
    };
    let filter = if nearest { 9728 } else { 9729 };
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2}},"indices":3,
"material":0}}]}}],
"materials":[{{"name":"worn","pbrMetallicRoughness":{{"baseColorTexture":{},
"baseColorFactor":[0.9,0.8,0.7,1],"metallicRoughnessTexture":{},"metallicFactor":0.75,
"roughnessFactor":0.5}},"emissiveTexture":{},"emissiveFactor":[0.1,0.2,0.3]}}],
"textures":[{{"source":0,"sampler":0}},{{"source":1,"sampler":0}},{{"source":2,"sampler":0}}],
"samplers":[{{"magFilter":{filter}}}],
"images":[{{"uri":"0.png"}},{{"uri":"1.png"}},{{"uri":"2.png"}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
{{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
{{"bufferView":2,"componentType":5126,"count":4,"type":"VEC3"}},
{{"bufferView":3,"componentType":5121,"count":6,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},
{{"buffer":0,"byteOffset":80,"byteLength":48}},{{"buffer":0,"byteOffset":128,"byteLength":6}}],
"buffers":[{{"uri":"square.bin","byteLength":134}}]}}"#,
        texture(0),
        texture(1),
        texture(2)
    );
    std::fs::write(folder.join("square.gltf"), json).expect("a mesh");
}

/// Pixels along an edge: three a texel, so that no centre lies on a border of two.
const PIXELS: usize = 24;

/// What the square mirrors everywhere: a ball behind the eye.
const SEEN: Vec3 = Vec3([0.5, 0.25, 1.0]);

const LAMP: [f64; 3] = [0.25, 0.5, 3.0];
const EMISSIVITY: f64 = 6.0;

fn script(things: &str) -> String {
    let [x, y, z] = LAMP;
    format!(
        "image(#{{ width: {PIXELS}, height: {PIXELS} }});
settings(#{{ attenuation: \"none\" }});
camera(#{{ viewpoint: [0, 0, 2], window: [2, 2] }});
light(#{{ at: [{x}, {y}, {z}], emissivity: {EMISSIVITY} }});
sphere(#{{ center: [0, 0, 60], radius: 50, material: #{{ ambient: [0.5, 0.25, 1] }} }});
{things}"
    )
}

/// The texture at (s, t), t downward, repeated.
fn at(texels: &[[f64; 3]], [s, t]: [f64; 2], nearest: bool) -> Vec3 {
    let n = TEXELS as i64;
    let texel = |i: i64, j: i64| {
        let [x, y, z] = texels[(j.rem_euclid(n) * n + i.rem_euclid(n)) as usize];
        v3(x, y, z)
    };
    let (x, y) = (s * TEXELS as f64, t * TEXELS as f64);
    if nearest {
        return texel(x.floor() as i64, y.floor() as i64);
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (i, j) = (x.floor(), y.floor());
    let (a, b) = (x - i, y - j);
    let (i, j) = (i as i64, j as i64);
    let row = |j| texel(i, j) * (1.0 - a) + texel(i + 1, j) * a;
    row(j) * (1.0 - b) + row(j + 1) * b
}

fn times(a: Vec3, b: Vec3) -> Vec3 {
    a.zip(b, |a, b| a * b)
}

/// The picture by the model: `colours` multiply the material's own.
fn expected(nearest: bool, [ambient, diffuse, specular]: [f64; 3]) -> Vec<Vec3> {
    let colours = |which| {
        let all = texels(which).into_iter();
        all.map(|texel| texel.map(decoded)).collect::<Vec<_>>()
    };
    let data: Vec<[f64; 3]> =
        texels(1).into_iter().map(|texel| texel.map(|sample| f64::from(sample) / 255.0)).collect();
    let (base, emission) = (colours(0), colours(2));
    let pixel = |i: usize| {
        let (x, y) = ((i % PIXELS) as f64 + 0.5, (i / PIXELS) as f64 + 0.5);
        let (u, v) = (x / PIXELS as f64, y / PIXELS as f64);
        let place = [2.0 * u, 2.0 * v];
        let p = v3(2.0 * u - 1.0, 1.0 - 2.0 * v, 0.0);
        let colour = v3(1.0, 1.0 - 0.5 * u, 1.0 - 0.75 * u);
        let base = times(times(v3(0.9, 0.8, 0.7), at(&base, place, nearest)), colour);
        let texel = at(&data, place, nearest);
        let share = 0.75 * texel[2] * (1.0 - 0.5 * texel[1]);
        let [lx, ly, lz] = LAMP;
        let way = v3(lx, ly, lz) - p;
        let r = way.length();
        let light = EMISSIVITY * (way[2] / r) / r;
        times(v3(0.1, 0.2, 0.3), at(&emission, place, nearest)) * ambient
            + base * ((1.0 - share) * light * diffuse)
            + times(base, SEEN) * (share * specular)
    };
    (0..PIXELS * PIXELS).map(pixel).collect()
}

/// What f32 may lose: a hit point is off by 2^-23 at most, which is 2^-20 of a texel's width here, so
/// of a value by as much times the contrast of two texels (below 6, times 1 for each of three
/// textures); and two dozen roundings of 2^-24 each of values below 6.
const LOST: f64 = 3.0 * 6.0 / 1_048_576.0 + 24.0 * 6.0 / 16_777_216.0;

fn hold(picture: &Picture, expected: &[Vec3], name: &str) {
    for (i, (got, want)) in picture.pixels.iter().zip(expected).enumerate() {
        let off = (*got - *want).length();
        assert!(
            off <= LOST,
            "{name}, pixel {}, {}: {got:?} is not {want:?}",
            i % PIXELS,
            i / PIXELS
        );
    }
}

fn shot(name: &str, script: &str, arguments: &[&str]) -> Picture {
    let path = folder("textured-meshes").join(format!("{name}.rhai"));
    render(&path, script, arguments).unwrap_or_else(|why| panic!("{why}")).picture
}

#[test]
fn a_square_wears_the_textures_of_its_file() {
    let folder = folder("textured-meshes");
    for nearest in [true, false] {
        write(&folder, nearest);
        let name = if nearest { "nearest" } else { "bilinear" };
        let mesh = script("let m = mesh(#{ file: \"square.gltf\" });");
        hold(&shot(name, &mesh, &[]), &expected(nearest, [1.0; 3]), name);
        // Colours of the script and those of the file are factors of each other.
        let edits = "m.materials.worn.specular *= 0.5;\nm.materials.worn.ambient *= 2;";
        let edited = shot(&format!("{name}-edited"), &format!("{mesh}\n{edits}"), &[]);
        hold(&edited, &expected(nearest, [2.0, 1.0, 0.5]), name);
    }
    // What stands in the place of the file's material is not of the file.
    let put = "let m = mesh(#{ file: \"square.gltf\", materials: #{ worn: #{ ambient: 0.5 } } });";
    assert!(shot("put", &script(put), &[]).pixels.iter().all(|pixel| *pixel == Vec3::splat(0.5)));
    the_picture_does_not_depend_on_how_it_was_made();
}

/// In the same test, since the files are written once.
fn the_picture_does_not_depend_on_how_it_was_made() {
    let mesh = script("let m = mesh(#{ file: \"square.gltf\" });");
    let whole = shot("whole", &mesh, &[]).pixels;
    assert_eq!(shot("scalar", &mesh, &["--isa", "scalar"]).pixels, whole);
    // The instance puts each corner where the mesh itself has it: to 40 and back is exact.
    let copy = script(
        "let m = mesh(#{ file: \"square.gltf\", translate: [0, 0, -40], visible: false });
instance(m, #{ translate: [0, 0, 40] });",
    );
    assert_eq!(shot("copy", &copy, &[]).pixels, whole);
    let edits = "animation(#{ frames: 4 });
on_frame(|f| {
    m.materials.worn.specular *= [1, 0, 0.5, 1][f.index];
    m.materials.worn.diffuse *= 1 - 0.25 * f.index;
    if f.index == 3 { m.translate = [0.125, 0, 0]; }
});";
    let moving = format!("{mesh}\n{edits}");
    let path = folder("textured-meshes").join("moving.rhai");
    let kept = render(&path, &moving, &[]).unwrap_or_else(|why| panic!("{why}"));
    let frames: Vec<&str> =
        kept.events.lines().filter(|line| line.contains("\"event\":\"frame\"")).collect();
    // Colours alone cast no ray.
    for frame in &frames[1..3] {
        assert!(frame.contains("\"rays\":{\"camera\":0,\"mirror\":0,\"shadow\":0}"), "{frame}");
    }
    let read = |i: usize| {
        let path = folder("textured-meshes").join(format!("moving-{i:04}.pfm"));
        std::fs::read(&path)
            .or_else(|_| std::fs::read(path.with_file_name(format!("moving-{i}.pfm"))))
    };
    let reused: Vec<_> = (1..4).map(|i| read(i).expect("a frame")).collect();
    render(&path, &moving, &["--no-reuse"]).unwrap_or_else(|why| panic!("{why}"));
    for (i, reused) in reused.iter().enumerate() {
        assert!(read(i + 1).expect("a frame") == *reused, "frame {}", i + 1);
    }
}
