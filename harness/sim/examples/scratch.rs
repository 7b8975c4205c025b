#![allow(missing_docs)]
#[path = "../tests/common/mod.rs"]
mod common;
use common::*;
use vb_sim::*;
use vb_world::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let pitch: f64 = a.get(2).map_or(0.1, |s| s.parse().unwrap());
    let step: f64 = a.get(3).map_or(1e-3, |s| s.parse().unwrap());
    let set = match a.get(4).map(String::as_str) {
        Some("default") => soils(),
        _ => original_soils(),
    };
    let classes = [TerrainClass::Snow, TerrainClass::Mud, TerrainClass::Sand];
    let options = SimOptions { step, soil_pitch: pitch, ..SimOptions::default() };
    let per = (0.01 / step).round() as u64;
    if a[1] == "rate" {
        let soils2 = soils();
        for (name, w) in [
            ("rigid", flat(0.8)),
            ("snow", soil_world(Heightfield::flat(301, 301, 1.0, 0.0), TerrainClass::Snow)),
            ("mud", soil_world(Heightfield::flat(301, 301, 1.0, 0.0), TerrainClass::Mud)),
            ("sand", soil_world(Heightfield::flat(301, 301, 1.0, 0.0), TerrainClass::Sand)),
        ] {
            let set = if a.len() > 4 { &set } else { &soils2 };
            let mut sim =
                Simulation::new(w, &hmmwv(), set, Pose2 { x: -100.0, y: 0.0, yaw: 0.0 }, options).unwrap();
            let mut best = f64::MAX;
            for _ in 0..400 {
                let t0 = std::time::Instant::now();
                for _ in 0..10 {
                    let c = hold_speed(&sim, 4.0, 0.0);
                    sim.advance(c, per).unwrap();
                }
                best = best.min(t0.elapsed().as_secs_f64());
            }
            println!("{name} best {:.0}x v {:.2}", 0.1 / best, sim.state().velocity.x);
        }
        return;
    }
    for c in classes {
        if a[1] == "rig" {
            let w =
                SoilSet::parse(&std::fs::read_to_string("/work/main/tasks/soils/wong.yaml").unwrap(), "w")
                    .unwrap();
            let rig =
                WheelRig { radius: 0.467, width: 0.3175, load: 2597.0 * 9.81 / 4.0, speed: 1.0, step, pitch };
            let mut all: Vec<(String, SoilLaw)> = w.soils.into_iter().collect();
            for (n, l) in original_soils().soils {
                let mut l = l;
                l.pressure = PressureDirection::Radial;
                l.damping = 0.0;
                l.bulldozing = None;
                all.push((n, l));
            }
            for (n, l) in all {
                let z = rig.run(&l, 0.0, 1);
                let tow = {
                    let t = rig.run(&l, -0.0, 1);
                    t
                };
                let _ = tow;
                let f = |s: f64| rig.run(&l, s, 1).drawbar / rig.load;
                let two = rig.run(&l, 0.2, 2);
                println!(
                    "{n:20} z {:.4} [{:.0} {:.0}] DP/W 0:{:.3} .05:{:.3} .2:{:.3} .5:{:.3} .8:{:.3}  z20 {:.4} second {:.4}",
                    z.sinkage,
                    z.load_range[0],
                    z.load_range[1],
                    z.drawbar / rig.load,
                    f(0.05),
                    f(0.2),
                    f(0.5),
                    f(0.8),
                    rig.run(&l, 0.2, 1).sinkage,
                    two.sinkage
                );
            }
            return;
        }
        if a[1] == "static" {
            let w = soil_world(Heightfield::flat(65, 65, 1.0, 0.0), c);
            let mut sim =
                Simulation::new(w, &hmmwv(), &set, Pose2 { x: 0.0, y: 0.0, yaw: 0.0 }, options).unwrap();
            sim.advance(Controls { steering: 0.0, throttle: 0.0, brake: 1.0 }, 300 * per).unwrap();
            let s = sim.state();
            println!(
                "{c:?} z {:.4} sink {:?} load {:?} v {:.2e}",
                s.position.z,
                s.wheels.iter().map(|w| (w.sinkage * 1e4).round() / 1e4).collect::<Vec<_>>(),
                s.wheels.iter().map(|w| w.load.round()).collect::<Vec<_>>(),
                s.velocity.norm()
            );
        }
        if a[1] == "drive" {
            for th in [0.3, 0.6, 1.0] {
                let w = soil_world(Heightfield::flat(65, 601, 1.0, 0.0), c);
                let mut sim =
                    Simulation::new(w, &hmmwv(), &set, Pose2 { x: -250.0, y: 0.0, yaw: 0.0 }, options)
                        .unwrap();
                let t0 = std::time::Instant::now();
                for i in 0..1000 {
                    let s = sim.state();
                    let (_, _, yaw) = s.roll_pitch_yaw();
                    let target = vb_math::atan2(-s.position.y, 10.0) - yaw;
                    sim.advance(
                        Controls { steering: target.clamp(-1.0, 1.0), throttle: th, brake: 0.0 },
                        per,
                    )
                    .unwrap();
                    if i == 499 || i == 999 {
                        let s = sim.state();
                        let slip = 1.0
                            - s.velocity.x / (0.467 * s.wheels.iter().map(|w| w.speed).sum::<f64>() / 4.0);
                        println!(
                            "{c:?} th {th} t {:.1} v {:.3} d {:.2} slip {slip:.3} sink {:?}  rtf {:.0}",
                            s.time,
                            s.velocity.x,
                            s.position.x + 250.0,
                            s.wheels.iter().map(|w| (w.sinkage * 1e4).round() / 1e4).collect::<Vec<_>>(),
                            s.time / t0.elapsed().as_secs_f64()
                        );
                    }
                }
            }
        }
        if a[1] == "grade" {
            for deg in [10.0, 15.0, 18.0, 20.0, 22.0, 25.0, 28.0f64] {
                let sl = deg.to_radians().tan();
                let h = (0..65 * 201).map(|i| sl * (i % 201) as f64).collect();
                let w = soil_world(Heightfield::new(65, 201, 1.0, h), c);
                let mut sim =
                    Simulation::new(w, &hmmwv(), &set, Pose2 { x: -70.0, y: 0.0, yaw: 0.0 }, options)
                        .unwrap();
                let x0 = sim.state().position.x;
                for _ in 0..2000 {
                    let s = sim.state();
                    let (_, _, yaw) = s.roll_pitch_yaw();
                    let target = vb_math::atan2(-s.position.y, 10.0) - yaw;
                    let c = hold_speed(&sim, 4.0, target.clamp(-1.0, 1.0));
                    sim.advance(c, per).unwrap();
                }
                let s = sim.state();
                let d = (s.position.x - x0) / deg.to_radians().cos();
                println!(
                    "{c:?} {deg} d {d:.2} v {:.3} wheel {:.2} y {:.2} sink {:?}",
                    s.velocity.x,
                    s.wheels[0].speed * 0.467,
                    s.position.y,
                    s.wheels.iter().map(|w| (w.sinkage * 1e4).round() / 1e4).collect::<Vec<_>>()
                );
            }
        }
    }
}
