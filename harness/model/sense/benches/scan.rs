//! The cost of a scan of 32 × 512 rays on one core: `cargo bench -p vb-sense`. parry's heightfield is the baseline.

use criterion::{Criterion, criterion_group, criterion_main};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::HeightField;
use parry3d_f64::utils::Array2;
use std::hint::black_box;
use std::sync::Arc;
use vb_sdk::metadata::Need;
use vb_sense::rays::{Ruts, Scene};
use vb_sense::{Perception, Profile, Seed, Truth};
use vb_sim::{Gear, VehicleState, WheelState};
use vb_vehicle::VehicleSpec;
use vb_world::{Heightfield, Obstacle, ObstacleKind, TerrainClass, World};

type V3 = nalgebra::Vector3<f64>;

const ROWS: usize = 32;
const COLS: usize = 512;
const REACH: f64 = 100.0;

/// Hills of a few metres with roughness on them, over 128 m, and 20 boulders.
fn hills() -> World {
    let n = 129;
    let mut s = vb_math::rng::Stream::new(2, &["bench"]);
    let height = |i: usize| {
        let (x, y) = ((i % n) as f64, (i / n) as f64);
        2.0 + 1.5 * vb_math::sin(0.13 * x) * vb_math::cos(0.11 * y) + 0.4 * vb_math::sin(0.7 * x + 0.5 * y)
    };
    let heights = (0..n * n).map(|i| height(i) + s.normal(0.0, 0.05)).collect();
    let field = Heightfield::new(n, n, 1.0, heights);
    let obstacles = (0..20)
        .map(|seed| Obstacle {
            x: s.uniform(-60.0, 60.0),
            y: s.uniform(-60.0, 60.0),
            yaw: s.uniform(0.0, 6.0),
            buried: 1.0,
            kind: ObstacleKind::Boulder { size: [4.4, 4.0, 3.8], seed },
        })
        .collect();
    World { obstacles, ..World::uniform("bench", field, TerrainClass::Concrete, 0.8) }
}

/// Ground that has changed nowhere near.
struct Untouched;

impl Ruts for Untouched {
    fn change(&self, _: f64, _: f64) -> Option<f64> {
        None
    }

    fn cell(&self) -> f64 {
        0.1
    }
}

/// The rays of a scan in world axes, column by column, from a vehicle that leans a little.
fn directions() -> Vec<V3> {
    let lean = nalgebra::UnitQuaternion::from_euler_angles(0.08, -0.05, 0.3);
    let mut all = Vec::with_capacity(ROWS * COLS);
    for col in 0..COLS {
        let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * (col as f64 + 0.5) / COLS as f64);
        for row in 0..ROWS {
            let elevation = (-22.5 + 45.0 * row as f64 / (ROWS - 1) as f64).to_radians();
            let (up, flat) = vb_math::sin_cos(elevation);
            all.push(lean * V3::new(flat * c, flat * s, up));
        }
    }
    all
}

fn scan(c: &mut Criterion) {
    let mut group = c.benchmark_group("scan of 32 x 512");
    let world = Arc::new(hills());
    let bare = Arc::new(World { obstacles: Vec::new(), ..(*world).clone() });
    let origin = V3::new(3.3, -7.7, world.heightfield.height(3.3, -7.7) + 2.0);
    let rays = directions();
    let cases: [(&str, &Arc<World>, Option<&dyn Ruts>); 3] = [
        ("ground", &bare, None),
        ("ground and obstacles", &world, None),
        ("also soil", &world, Some(&Untouched)),
    ];
    for (name, world, ruts) in cases {
        let scene = Scene::new(world.clone());
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut sum = 0.0;
                for column in rays.chunks_exact(ROWS) {
                    let (low, high) = (&column[0], &column[ROWS - 1]);
                    let mut fan =
                        scene.fan(&origin, &low.cross(high).normalize(), &(low + high).normalize(), REACH);
                    for ray in column {
                        sum += fan.cast(ray, ruts).map_or(0.0, |h| h.distance);
                    }
                }
                black_box(sum)
            });
        });
    }
    // parry's surface has y up, and its rows go along z.
    let field = &bare.heightfield;
    let heights = Array2::from_fn(field.rows(), field.cols(), |r, c| field.node(field.rows() - 1 - r, c));
    let parry = HeightField::new(heights, Vector::new(2.0 * field.half_x(), 1.0, 2.0 * field.half_y()));
    let turn = |v: &V3| Vector::new(v.x, v.z, -v.y);
    let turned: Vec<Ray> = rays.iter().map(|d| Ray::new(turn(&origin), turn(d))).collect();
    group.bench_function("ground by parry", |b| {
        b.iter(|| {
            black_box(turned.iter().filter_map(|r| parry.cast_local_ray(r, REACH, false)).sum::<f64>())
        });
    });
    group.finish();
}

/// What sensors cost a trial for 0.1 s, in which each of those that look around measures once.
fn sensors(c: &mut Criterion) {
    let mut group = c.benchmark_group("0.1 s of onboard");
    let spec =
        VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").expect("valid");
    let onboard = Profile::built_in("onboard").expect("shipped");
    let scene = Arc::new(Scene::new(Arc::new(hills())));
    let state = VehicleState {
        time: 0.0,
        position: V3::new(3.3, -7.7, scene.world().heightfield.height(3.3, -7.7) + 0.6),
        attitude: nalgebra::UnitQuaternion::from_euler_angles(0.08, -0.05, 0.3),
        velocity_body: V3::zeros(),
        angular_velocity_body: V3::zeros(),
        wheels: vec![WheelState::default(); 4],
        steering: 0.0,
        gear: Gear::Forward,
        engine_speed: 0.0,
    };
    let seed = Seed { run: 1, task: "w001/t01".to_owned() };
    for names in [&["pose", "wheel-odometry", "imu", "gnss"][..], &["lidar"], &["depth"], &["local-map"]] {
        let needs: Vec<Need> = names.iter().map(|n| Need::parse(n).expect("a sensor")).collect();
        let mut p = Perception::new(&onboard, &needs, &scene, &spec, &seed).expect("offered");
        group.bench_function(names.join(" "), |b| {
            b.iter(|| {
                for _ in 0..10 {
                    p.sample(Truth { state: &state, ruts: None });
                }
                black_box(p.read(&state))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, scan, sensors);
criterion_main!(benches);
