//! The materials of a mesh's file: worn as they are, put in place of, and animated by name.

mod oracle;

use oracle::binary::{folder, rendered};
use oracle::hand::classic;
use oracle::view::Picture;

/// Two squares side by side, x from -1 to 0 in `red` and from 0 to 1 in `glass of water`, then a
/// triangle above both that the file gives no material.
const OBJ: &str = "mtllib squares.mtl
v -1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\nv 1 0 0\nv 1 1 0\nv 0 -1 0
f 2 7 5
usemtl red
f 1 2 3\nf 1 3 4
usemtl glass of water
f 2 5 6\nf 2 6 3
";
const MTL: &str =
    "newmtl red\nKd 0.5 0 0\nKs 0 0 0\nnewmtl glass of water\nKd 0 0 1\nKs 0.25 0 0\n";

/// The same as single triangles.
const ALONE: &str = "triangle(#{ a: [0, 0, 0], b: [0, -1, 0], c: [1, 0, 0], material: bare });
triangle(#{ a: [-1, 0, 0], b: [0, 0, 0], c: [0, 1, 0], material: red });
triangle(#{ a: [-1, 0, 0], b: [0, 1, 0], c: [-1, 1, 0], material: red });
triangle(#{ a: [0, 0, 0], b: [1, 0, 0], c: [1, 1, 0], material: water });
triangle(#{ a: [0, 0, 0], b: [1, 1, 0], c: [0, 1, 0], material: water });";

const LAMP: &str = "light(#{ at: [0.3, 0.4, 3], emissivity: 9 });
sphere(#{ center: [0, 0, 5], radius: 1, material: #{ ambient: [0.5, 0.25, 0] } });";

fn files() {
    let folder = folder("model");
    std::fs::write(folder.join("squares.obj"), OBJ).expect("a mesh");
    std::fs::write(folder.join("squares.mtl"), MTL).expect("its materials");
}

/// What triangles wear of which the file says nothing: what anything wears that is given nothing.
const BARE: &str = "ambient: 0.05, diffuse: 0.6";

/// The picture of a mesh, made by `mesh`, and of single triangles in these materials.
fn both(name: &str, mesh: &str, [bare, red, water]: [&str; 3]) -> [Picture; 2] {
    files();
    let alone = format!(
        "{LAMP}
let bare = material(#{{ {bare} }});
let red = material(#{{ {red} }});
let water = material(#{{ {water} }});
{ALONE}"
    );
    [format!("{LAMP}\n{mesh}"), alone].map(|things| {
        let name = format!("materials-{name}-{}", things.contains("mesh("));
        classic(&name, 24, 3.0, &things).picture
    })
}

fn hold(name: &str, mesh: &str, materials: [&str; 3]) {
    let [mesh, alone] = both(name, mesh, materials);
    let differ = mesh.pixels.iter().zip(&alone.pixels).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "pixels of {name}");
}

#[test]
fn a_mesh_wears_what_its_file_says() {
    let worn = "mesh(#{ file: \"squares.obj\" });";
    let red = "diffuse: [0.5, 0, 0]";
    hold("file", worn, [BARE, red, "diffuse: [0, 0, 1], specular: [0.25, 0, 0]"]);
    let [mesh, other] = both("other", worn, [BARE, red, "diffuse: [0, 0, 1]"]);
    assert_ne!(mesh.pixels, other.pixels, "what water mirrors is to be seen");
}

#[test]
fn materials_are_written_by_name() {
    let written = "let m = mesh(#{ file: \"squares.obj\" });
m.materials.red.diffuse = [0, 0.5, 0];
m.materials[\"glass of water\"].specular *= 2;";
    let water = "diffuse: [0, 0, 1], specular: [0.5, 0, 0]";
    hold("written", written, [BARE, "diffuse: [0, 0.5, 0]", water]);
    let put = "let mine = material(#{ diffuse: 0.125 });
let m = mesh(#{ file: \"squares.obj\", materials: #{ red: mine } });
m.materials[\"glass of water\"] = #{ specular: 0.5 };";
    hold("put", put, [BARE, "diffuse: 0.125", "specular: 0.5"]);
    let listed = "let m = mesh(#{ file: \"squares.obj\" });
let names = m.materials.keys();
if names != [\"\", \"red\", \"glass of water\"] || m.materials.len() != 3 { throw names; }
for (own, i) in m.materials.values() { own.diffuse = i; own.ambient = 0; own.specular = 0; }";
    hold("listed", listed, ["diffuse: 0", "diffuse: 1", "diffuse: 2"]);
    let whole = "mesh(#{ file: \"squares.obj\", material: #{ diffuse: 0.7 } });";
    hold("whole", whole, ["diffuse: 0.7"; 3]);
    let later =
        "let m = mesh(#{ file: \"squares.obj\" });\nm.material = material(#{ diffuse: 0.7 });";
    hold("later", later, ["diffuse: 0.7"; 3]);
}

#[test]
fn instances_wear_the_same_materials() {
    let copy = "let m = mesh(#{ file: \"squares.obj\", translate: [0, 0, -50] });
m.visible = false;
instance(m, #{ translate: [0, 0, 50] });
m.materials.red.diffuse = [0.25, 0.5, 0];";
    let water = "diffuse: [0, 0, 1], specular: [0.25, 0, 0]";
    hold("copy", copy, [BARE, "diffuse: [0.25, 0.5, 0]", water]);
}

#[test]
fn an_animated_material_of_a_file_casts_no_ray_after_the_first_frame() {
    files();
    let script = format!(
        "image(#{{ width: 24, height: 24 }});
camera(#{{ viewpoint: [0, 0, 2], window: [3, 3] }});
{LAMP}
let m = mesh(#{{ file: \"squares.obj\" }});
animation(#{{ frames: 3 }});
on_frame(|f| {{ m.materials[\"glass of water\"].specular = 0.25 + 0.5 * f.t; }});"
    );
    let events = rendered("materials-animated", &script).events;
    let frames: Vec<&str> = events.lines().filter(|l| l.contains("\"event\":\"frame\"")).collect();
    assert_eq!(frames.len(), 3, "{events}");
    assert!(!frames[0].contains("\"camera\":0"), "{events}");
    for frame in &frames[1..] {
        assert!(frame.contains("\"rays\":{\"camera\":0,\"mirror\":0,\"shadow\":0}"), "{frame}");
    }
}
