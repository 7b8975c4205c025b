//! Draws a task at its start: `cargo run --release -p vb-render --example picture -- w003 t00 hmmwv pictures/start`
//! writes `pictures/start-chase.png`, `-top.png` and `-near.png`. More words after these: `steer=0.8`, `roll=180`
//! (degrees), `drive=3` (seconds of full throttle).

use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vb_render::{Moment, Painter, Size, View};
use vb_sim::{Controls, SimOptions, Simulation, SoilSet};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::Suite;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [world, task, vehicle, out, rest @ ..] = &words[..] else {
        return Err("name a world, a task, a vehicle and the beginning of the pictures' paths".into());
    };
    let number =
        |name: &str| rest.iter().find_map(|w| w.strip_prefix(name)?.strip_prefix('=')?.parse::<f64>().ok());
    let tasks = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../tasks");
    let spec = VehicleSpec::load(&tasks.join(format!("vehicles/{vehicle}.yaml")))?;
    let scale = spec.scale;
    let model = VehicleModel::new(spec)?;
    let suite = rest.iter().find_map(|w| w.strip_prefix("suite=")).unwrap_or("vb-100");
    let world = Arc::new(Suite::open(tasks.join(suite))?.load_world(world)?.scaled(scale));
    let task = world.task(task).ok_or("no such task")?;
    let mut sim = Simulation::new(
        world.clone(),
        &model,
        &SoilSet::load(&tasks.join("soils/default.yaml"))?,
        task.start,
        SimOptions::default(),
    )?;
    let mut trail = Vec::new();
    let mut turned = vec![0.0; 2 * model.axles().len()];
    let controls =
        Controls { steering: number("steer").unwrap_or(0.0), throttle: 0.6, ..Controls::default() };
    for _ in 0..(number("drive").unwrap_or(0.0) * 20.0) as usize {
        sim.advance(controls, 50)?;
        let state = sim.state();
        trail.push(state.position.into());
        for (angle, wheel) in turned.iter_mut().zip(&state.wheels) {
            *angle += 0.05 * wheel.speed;
        }
    }
    let mut state = sim.state();
    if let Some(steering) = number("steer") {
        state.steering = steering;
    }
    if let Some(roll) = number("roll") {
        let axis = nalgebra::Vector3::x_axis();
        state.attitude *= nalgebra::UnitQuaternion::from_axis_angle(&axis, vb_math::angle::radians(roll));
        state.position.z += number("lift").unwrap_or(0.0);
    }
    let change = |x: f64, y: f64| sim.soil_change(x, y);
    let grains: Vec<([f64; 3], f64)> = sim.grains().collect();
    let moment = Moment {
        state: &state,
        turned: &turned,
        goal: task.goal,
        goal_radius: 2.0 * world.scale,
        path: &task.path,
        trail: &trail,
        change: Some(&change),
        grains: &grains,
        colour: None,
    };
    let painter = Painter::new(&world, &model);
    let views = [
        ("chase", View::Chase, Size { width: 640, height: 480 }),
        ("top", View::Top { window: None }, Size { width: 640, height: 640 }),
        ("near", View::Top { window: Some(24.0 * world.scale) }, Size { width: 480, height: 480 }),
    ];
    for (name, view, size) in views {
        let pixels = painter.picture(view, size, &moment)?;
        write(Path::new(&format!("{out}-{name}.png")), size, &pixels)?;
    }
    Ok(())
}

fn write(path: &Path, size: Size, pixels: &[u8]) -> Result<(), Box<dyn Error>> {
    let mut encoder = png::Encoder::new(File::create(path)?, size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(())
}
