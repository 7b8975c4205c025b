//! The CPU's part of what GPUs are compared with.

use std::path::Path;
use std::sync::Arc;

use vb_catalog::Catalog;
use vb_gpu::{Course, CourseError, Drive, TIME_STEP, same};
use vb_sim::{Controls, Simulation, StateHash};

fn course(time_step: f64) -> Result<Course, CourseError> {
    let catalog = Catalog::at(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks"));
    Course::new(&catalog, Path::new("smoke"), Some("w001/t00,w004/t00"), "hmmwv", time_step)
}

/// That the first vehicle of a drive of 0.3 s on the CPU has the states of a simulation of its own.
fn compare(time_step: f64) {
    let course = course(time_step).expect("it is there");
    let drive = Drive::new(&course, 0.3);
    assert_eq!((drive.periods(), drive.tasks(3)), (3, vec![Some(0), Some(1), Some(0)]));

    let hashes = drive.on_cpu(&drive.starts_on_cpu(3), 3);
    let (world, task) = &course.tasks[0];
    let setting = &course.setting;
    let place = Arc::new(course.worlds[*world].clone());
    let mut alone = Simulation::new(place, &setting.model, &setting.soils, task.start, setting.options)
        .expect("the vehicle stands");
    // Those of the vehicle with the number 0.
    let controls = Controls { steering: -0.5, throttle: 0.2, ..Controls::default() };
    let mut hash = StateHash::default();
    alone.visit_state(|x| hash.push(x));
    for _ in 0..30 {
        alone.advance(controls, (0.01 / time_step).round() as u64).expect("it drives");
        alone.visit_state(|x| hash.push(x));
    }
    assert_eq!(hashes[0], Some(hash.value()));
    // They begin the same task, with other controls.
    assert!(hashes[2].is_some() && hashes[2] != hashes[0]);
}

#[test]
fn drives_on_the_cpu_are_those_of_single_simulations() {
    compare(TIME_STEP);
    compare(0.005);
}

#[test]
fn time_steps_that_dont_divide_the_time_between_samples_are_refused() {
    for step in [0.0, 0.003, 0.01, -0.001, f64::NAN] {
        let told = course(step).err().expect("it isn't one").to_string();
        assert!(told.starts_with("time_step: ") && told.contains("0.005"), "{told}");
    }
}

#[test]
fn vehicles_that_diverged_are_not_compared() {
    assert_eq!(same(&[Some(1), None, Some(3)], &[1, 2, 4]), (1, 2));
}
