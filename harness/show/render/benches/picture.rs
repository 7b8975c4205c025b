//! The cost of a picture on one core: `cargo bench -p vb-render`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::PathBuf;
use std::sync::Arc;
use vb_render::{Moment, Painter, Size, View};
use vb_sim::{Gear, VehicleState, WheelState};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Suite, World};

type V3 = nalgebra::Vector3<f64>;

fn tasks() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../tasks")
}

fn model(name: &str) -> VehicleModel {
    let spec = VehicleSpec::load(&tasks().join(format!("vehicles/{name}.yaml"))).expect("shipped");
    VehicleModel::new(spec).expect("valid")
}

/// A mixed world with steep hills and 40 boulders.
fn world() -> Arc<World> {
    Arc::new(Suite::open(tasks().join("vb-100")).and_then(|s| s.load_world("w090")).expect("shipped"))
}

/// The same ground with four times as many nodes along each side.
fn fine(world: &World) -> Arc<World> {
    let (field, n) = (&world.heightfield, 4 * (world.heightfield.cols() - 1) + 1);
    let resolution = 2.0 * field.half_x() / (n - 1) as f64;
    let at = |k: usize| k as f64 * resolution - field.half_x();
    let heights = (0..n * n).map(|i| field.height(at(i % n), at(i / n))).collect();
    let heightfield = vb_world::Heightfield::new(n, n, resolution, heights);
    Arc::new(World { heightfield, ..world.clone() })
}

/// On the way, with the trail of a minute behind it.
fn draw(c: &mut Criterion) {
    let world = world();
    let task = &world.tasks[5];
    let at = task.path[task.path.len() / 3];
    let next = task.path[task.path.len() / 3 + 1];
    let yaw = vb_math::atan2(next[1] - at[1], next[0] - at[0]);
    let state = VehicleState {
        time: 60.0,
        position: V3::new(at[0], at[1], world.heightfield.height(at[0], at[1]) + 0.7),
        attitude: nalgebra::UnitQuaternion::from_euler_angles(0.05, 0.05, yaw),
        velocity_body: V3::zeros(),
        angular_velocity_body: V3::zeros(),
        wheels: vec![WheelState::default(); 14],
        steering: 0.3,
        gear: Gear::Forward,
        engine_speed: 0.0,
    };
    let trail: Vec<[f64; 3]> = task.path[..task.path.len() / 3].iter().map(|p| [p[0], p[1], 0.0]).collect();
    let untouched = |_: f64, _: f64| None;
    let moment = Moment {
        state: &state,
        turned: &[],
        goal: task.goal,
        goal_radius: 2.0,
        path: &task.path,
        trail: &trail,
        change: Some(&untouched),
        grains: &[],
        colour: None,
    };
    let mut group = c.benchmark_group("picture");
    group.sample_size(40);
    let (hmmwv, m113) = (model("hmmwv"), model("m113"));
    let size = |width, height| Size { width, height };
    let painter = Painter::new(&world, &hmmwv);
    let tracked = Painter::new(&world, &m113);
    let large = Painter::new(&fine(&world), &hmmwv);
    let cases = [
        ("chase 640 x 480", &painter, View::Chase, size(640, 480)),
        ("chase 640 x 480, tracks", &tracked, View::Chase, size(640, 480)),
        ("chase 640 x 480, ground of 513 x 513", &large, View::Chase, size(640, 480)),
        ("chase 320 x 240", &painter, View::Chase, size(320, 240)),
        ("chase 1920 x 1080", &painter, View::Chase, size(1920, 1080)),
        ("top 480 x 480", &painter, View::Top { window: None }, size(480, 480)),
        ("top 480 x 480, ground of 513 x 513", &large, View::Top { window: None }, size(480, 480)),
        ("top 480 x 480 of 30 m", &painter, View::Top { window: Some(30.0) }, size(480, 480)),
    ];
    for (name, painter, view, size) in cases {
        group.bench_function(name, |b| {
            b.iter(|| black_box(painter.picture(view, size, &moment).expect("a valid size")));
        });
    }
    group.finish();
    let mut group = c.benchmark_group("painter");
    group.sample_size(20);
    group.bench_function("ground of 129 x 129", |b| b.iter(|| black_box(Painter::new(&world, &hmmwv))));
    group.finish();
}

criterion_group!(benches, draw);
criterion_main!(benches);
