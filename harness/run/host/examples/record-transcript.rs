//! Drives a planner along a winding path and prints the transcript for `tests/golden`. For the plugins of a new version
//! of the interface; those of released versions never change.
//!
//! `cargo run --release --package vb-host --example record-transcript -- FILE [TOLERANCE]`

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a tool for developers")]

#[path = "../tests/all/golden/transcript/mod.rs"]
mod transcript;

use std::path::PathBuf;
use std::process::ExitCode;

use transcript::{Step, Transcript, bits, observation};
use vb_host::{Limits, LogSink, Plugin};
use vb_sdk::math;

fn main() -> ExitCode {
    if let Some(end) = vb_host::serve_as_worker() {
        return end;
    }
    let mut args = std::env::args().skip(1);
    let file = PathBuf::from(args.next().expect("give the file of a plugin"));
    let plugin = Plugin::load(&file, &Limits::default(), None).unwrap();
    let mut transcript = Transcript {
        abi: plugin.metadata().abi.clone(),
        plugin: file.file_name().unwrap().to_string_lossy().into_owned(),
        tolerance: args.next().map_or(0.0, |t| t.parse().expect("a number")),
        wheelbase: 3.3,
        max_steer_angle: 0.6,
        params: vec![("speed".into(), "5".into())],
        path: (0..60).map(|i| f64::from(i) * 1.25).map(|x| [x, short(6.0 * math::sin(x * 0.12))]).collect(),
        steps: Vec::new(),
    };
    let mut session = plugin.start(&transcript.task(&plugin), LogSink::discard()).unwrap();
    let (mut x, mut y, mut yaw, mut speed) = (0.1, -1.3, 0.2, 0.0f64);
    let mut last = [0.0; 3];
    // A kinematic bicycle, whose state is rounded to what the transcript holds.
    for i in 0..120 {
        let mut sees = vec![short(f64::from(i) * 0.1), x, y, 0.4, 0.01, -0.02, yaw, speed, 0.03, -0.04];
        sees.extend([0.05, -0.06, 0.07]);
        sees.extend(last.map(short));
        for wheel in 0..4 {
            sees.extend([short(speed / 0.47), 0.01 * f64::from(wheel)]);
        }
        let (command, _) = session.step(&observation(&sees)).unwrap().clamped();
        transcript.steps.push(Step { sees, answers: bits(&command) });
        last = [command.steering, command.throttle, command.brake];
        speed = short(speed + 0.1 * (4.0 * command.throttle - 6.0 * command.brake - 0.1 * speed));
        yaw = short(yaw + 0.1 * speed / 3.3 * math::tan(0.6 * command.steering));
        x = short(x + 0.1 * speed * math::cos(yaw));
        y = short(y + 0.1 * speed * math::sin(yaw));
    }
    let answers: Vec<_> = transcript.steps.iter().map(|step| step.answers.clone()).collect();
    assert_eq!(transcript.replay(&plugin), answers, "the planner doesn't answer the same twice");
    // One step a line.
    let text = serde_json::to_string(&transcript).unwrap();
    println!("{}", text.replace("{\"sees\"", "\n{\"sees\"").replace("\"steps\"", "\n\"steps\""));
    ExitCode::SUCCESS
}

/// The nearest number of three decimal digits.
fn short(x: f64) -> f64 {
    (x * 1000.0).round() / 1000.0
}
