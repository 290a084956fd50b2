//! The world to columns: all of 100,000 spheres, and one material among them.

mod scenes;

use criterion::Throughput;
use reflet_scene::{DVec3, Material};
use scenes::Shape;

const SPHERES: u32 = 100_000;

fn main() {
    let (mut scene, material) = scenes::random_scene(Shape::Sphere, SPHERES);
    scenes::run(|criterion| {
        let mut group = criterion.benchmark_group("pack");
        group.throughput(Throughput::Elements(u64::from(SPHERES)));
        group.bench_function("whole", |b| b.iter(|| scenes::packed(&scene)));
        group.throughput(Throughput::Elements(1));
        let mut packer = scenes::packed(&scene);
        let mut gloss = 0.0;
        group.bench_function("one material", |b| {
            b.iter(|| {
                gloss = (gloss + 0.01) % 1.0;
                let specular = DVec3::splat(gloss);
                scene.set(material, Material { specular, ..Material::GREY_MATT });
                let changes = packer.update(&scene);
                scene.rewind();
                changes
            });
        });
        group.finish();
    });
}
