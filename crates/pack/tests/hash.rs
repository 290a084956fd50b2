//! The hash of a scene: every bit that decides a picture counts, and nothing else.

use glam::DVec3;
use reflet_pack::{Overrides, Packer, SceneHash, SceneHasher};
use reflet_scene::{
    Attenuation, Camera, Checker, Falloff, Image, Material, Mesh, MeshData, Plane, PointLight,
    Quad, Scene, Settings, Shading, Sphere, Spotlight, Surface, Tiles, TransferCurve, Triangle,
};
use std::collections::HashSet;
use std::sync::Arc;

/// A scene of one of everything, with the numbers of its nouns.
struct Nouns {
    numbers: Vec<f64>,
    image: Image,
    settings: Settings,
    visible: bool,
    /// Which of two materials the sphere wears.
    worn: usize,
}

/// How many numbers [`Nouns::scene`] takes.
const NUMBERS: usize = 54;

impl Nouns {
    fn new() -> Nouns {
        Nouns {
            numbers: (0..NUMBERS).map(|i| 0.5 + 0.37 * i as f64).collect(),
            image: Image { width: 8, height: 6, ..Image::default() },
            settings: Settings { max_path: 100.0, ..Settings::default() },
            visible: true,
            worn: 0,
        }
    }

    fn scene(&self) -> Scene {
        let mut rest = self.numbers.iter().copied();
        let mut one = || rest.next().expect("enough numbers");
        let mut scene = Scene::new();
        let mut three = || DVec3::new(one(), one(), one());
        let material = Material { ambient: three(), diffuse: three(), specular: three() };
        let first = scene.spawn((material,));
        let second = scene.spawn((Material::GREY_MATT,));
        let camera =
            Camera::LookAt { eye: three(), look_at: -three(), up: DVec3::Y, fov_degrees: 30.0 };
        scene.singletons.camera = Some(scene.spawn((camera,)));
        scene.singletons.image = Some(scene.spawn((self.image,)));
        scene.singletons.settings = Some(scene.spawn((self.settings,)));
        scene.spawn((PointLight { at: three(), emissivity: three(), falloff: Falloff::Inverse },));
        let (at, emissivity) = (three(), three());
        scene.spawn((Spotlight {
            at,
            aim: -three(),
            angle_degrees: 30.0,
            emissivity,
            falloff: Falloff::None,
        },));
        let wear = |material| Surface { material: Some(material), visible: true };
        let worn = Surface { visible: self.visible, ..wear([first, second][self.worn]) };
        let sphere = three();
        scene.spawn((Sphere { center: sphere, radius: 0.5 + sphere.x }, worn));
        let (point, normal) = (three(), three());
        let checker =
            Checker { even: first, odd: second, size: Tiles::Flat([1.0, 2.0]), xdir: three() };
        let checker = scene.spawn((checker,));
        scene.spawn((Plane { point, normal }, wear(checker)));
        let corner = three();
        scene.spawn((Quad { corner, u: DVec3::X * corner.x, v: DVec3::Y }, wear(first)));
        scene.spawn((Triangle { a: three(), b: -three(), c: DVec3::Z }, wear(first)));
        let data = MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        };
        // Data of its own at each call: the address counts for nothing.
        let mesh = Mesh {
            data: Arc::new(data),
            scale: 1.0,
            rotate: DVec3::ZERO,
            translate: three(),
            shading: Shading::Smooth,
            worn: [].into(),
        };
        scene.spawn((mesh, wear(second)));
        scene.seal();
        scene
    }

    fn hash(&self) -> SceneHash {
        let packer = Packer::new(&self.scene(), Overrides::default()).expect("a camera");
        SceneHasher::of(packer.columns())
    }
}

#[test]
fn the_same_nouns_have_the_same_hash() {
    assert_eq!(Nouns::new().hash(), Nouns::new().hash());
    assert_eq!(Nouns::new().hash().to_string().len(), 64);
}

#[test]
fn every_number_counts() {
    let mut seen = HashSet::from([Nouns::new().hash()]);
    let mut used = 0;
    for i in 0..NUMBERS {
        let mut nouns = Nouns::new();
        // The least step that an f32 can tell, and more than a unit vector can lose.
        nouns.numbers[i] *= 1.001;
        used += usize::from(seen.insert(nouns.hash()));
    }
    assert_eq!(used, NUMBERS);
    type Change = fn(&mut Nouns);
    let changes: [Change; 10] = [
        |n| n.image.width = 9,
        |n| n.image.height = 7,
        |n| n.image.samples = 2,
        |n| n.settings.max_bounces = 3,
        |n| n.settings.max_path = 99.0,
        |n| n.settings.attenuation = Attenuation::None,
        |n| n.settings.transfer = TransferCurve::Linear,
        |n| n.settings.background = DVec3::new(0.0, 0.0, -0.0),
        |n| n.visible = false,
        |n| n.worn = 1,
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut nouns = Nouns::new();
        change(&mut nouns);
        assert!(seen.insert(nouns.hash()), "change {i}");
    }
}

#[test]
fn what_is_hidden_does_not_count() {
    let hidden = |factor: f64| {
        let mut nouns = Nouns::new();
        nouns.visible = false;
        let sphere = 9 + 6 + 6 + 9;
        nouns.numbers[sphere] *= factor;
        (nouns.hash(), nouns.scene())
    };
    assert_eq!(hidden(1.0).0, hidden(1.001).0);
    let mut shown = Nouns::new();
    shown.numbers[9 + 6 + 6 + 9] *= 1.001;
    assert_ne!(shown.hash(), Nouns::new().hash());
}
