//! Steps of beds in which all grains move: 1 ms of simulated time.

use criterion::{Criterion, criterion_group, criterion_main};
use vb_granular::{Bed, Bin, MaterialFile, Motion, Packing, Settings, Shape, Tool};

type V3 = nalgebra::Vector3<f64>;

fn steps(c: &mut Criterion) {
    let gravel = MaterialFile::resolve("gravel").expect("a material that comes with the crate").grains;
    let mut group = c.benchmark_group("bed");
    for (grains, length) in [(2000, 2.25), (5000, 5.65), (10_000, 11.3)] {
        let packing = Packing::poured(&gravel, Bin { length, width: 0.9, depth: 0.4 }, 1).expect("it fits");
        let shape = Shape::Wheel { radius: 0.47, width: 0.26, shoulder: 0.03 };
        let wheel = Tool { shape, friction: 0.8, stiffness: f64::INFINITY };
        let mut bed = Bed::new(&packing, &gravel, vec![wheel], Settings::default());
        let mut time = 0.0;
        // The wheel moves from one end to the other and back.
        group.bench_function(format!("{grains} grains ({})", packing.grains.len()), |b| {
            b.iter(|| {
                let way = 0.4 * length * vb_math::sin(0.5 * time / length);
                time += 1e-3;
                let motion = Motion {
                    position: V3::new(way, 0.0, 0.83),
                    rotation: nalgebra::UnitQuaternion::identity(),
                    velocity: V3::new(0.2, 0.0, 0.0),
                    spin: V3::new(0.0, 1.0, 0.0),
                };
                bed.step(&[motion]).len()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
