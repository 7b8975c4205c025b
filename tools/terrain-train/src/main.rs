//! `vb-terrain-train`: what `vb-harness terrain train` runs. A program of its own, since what it computes with takes longer to
//! build than the harness.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use vb_terrain::data::Meaning;
use vb_terrain_train::{Card, End, Event, Options, Settings, TrainError, card_of, train};

/// Bad input and output that can't be written end as in `vb-harness`.
const INTERNAL: u8 = 1;
const USAGE: u8 = 2;
const BAD_INPUT: u8 = 3;
const OUTPUT: u8 = 4;

/// Train a terrain model on elevation data: BMP, PNG, NumPy arrays or GeoTIFF
#[derive(Debug, Parser)]
#[command(name = "vb-harness terrain train", version)]
struct Args {
    /// Folder of elevation data
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Where the model goes; its card goes beside it as .json
    #[arg(long, value_name = "MODEL")]
    out: PathBuf,
    /// Which parts of the data to use; default: terrain.yaml in the folder, if it is there
    #[arg(long, value_name = "FILE")]
    selection: Option<PathBuf>,
    /// Distance between samples in metres, where a file doesn't say it
    #[arg(long, value_name = "METRES", default_value = "1", value_parser = length)]
    resolution: f64,
    /// Learn from every so many-th sample along each side
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64))]
    every: u16,
    /// Standard deviation of height at full relief, in metres; default: that of the data
    #[arg(long, value_name = "METRES", value_parser = length)]
    relief: Option<f64>,
    /// Share of the noise that details are drawn from, from 0 to 1: less where the data's finest details are a sensor's noise
    #[arg(long, value_name = "SHARE", default_value = "0.6", value_parser = detail)]
    detail: f64,
    /// Passes over the data
    #[arg(long, value_name = "N", default_value_t = 55, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    epochs: u64,
    /// Train for so long instead; the model then depends on the machine
    #[arg(long, value_name = "N", conflicts_with = "epochs", value_parser = length)]
    minutes: Option<f64>,
    /// Names all random draws
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Go on from the checkpoint beside the model
    #[arg(long)]
    resume: bool,
}

fn length(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0 && *v <= 1e6);
    value.ok_or_else(|| "want a number above 0".into())
}

fn detail(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| (0.0..=1.0).contains(v));
    value.ok_or_else(|| "want a number from 0 to 1".into())
}

fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(e) if e.use_stderr() => {
            let text = e.render().to_string();
            let end = ["\n\nUsage:", "\n\nFor more"].iter().filter_map(|end| text.find(end)).min();
            let text = vb_files::one_line(&text[..end.unwrap_or(text.len())]);
            note(&format!("{text} (see --help)"));
            return ExitCode::from(USAGE);
        }
        Err(e) => {
            let _ = e.print();
            return ExitCode::SUCCESS;
        }
    };
    let out = args.out.clone();
    let options = Options {
        data: args.data,
        selection: args.selection,
        meaning: Meaning { resolution: args.resolution, every: usize::from(args.every) },
        relief: args.relief,
        detail: args.detail,
        out: args.out,
        settings: Settings { seed: args.seed, ..Settings::default() },
        end: args.minutes.map_or(End::Epochs(args.epochs), |m| End::Time(Duration::from_secs_f64(60.0 * m))),
        resume: args.resume,
    };
    match train(&options, tell) {
        Ok(card) => {
            note(&summary(&card));
            note(&format!("{} and {} are written", out.display(), card_of(&out).display()));
            ExitCode::SUCCESS
        }
        Err(e) => {
            note(&format!("error: {e}"));
            ExitCode::from(match e {
                TrainError::Data(_) | TrainError::TooLittle(_) | TrainError::Checkpoint { .. } => BAD_INPUT,
                TrainError::Write { .. } => OUTPUT,
                TrainError::Internal(_) => INTERNAL,
            })
        }
    }
}

/// How it goes, for people.
fn tell(event: Event) {
    match event {
        Event::Data(d) => note(&format!(
            "{} files to train on, {} held out; {} tiles, {} more were copies; {} pits and {} spikes repaired",
            d.trained.len(),
            d.held_out.len(),
            d.tiles,
            d.copies,
            d.pits,
            d.spikes
        )),
        Event::Resumed(step) => note(&format!("goes on after step {step}")),
        Event::Progress(p) => {
            let left = if p.fraction > 0.0 { p.pace * p.step as f64 * (1.0 / p.fraction - 1.0) } else { 0.0 };
            note(&format!(
                "{:>3.0} %  step {:>5}  reconstruction {:.3}  latent {:.3}  patches {:.3}  responses {:.3}  features {:.3}  {:.2} s a step, {:.0} min left",
                100.0 * p.fraction,
                p.step,
                p.losses.reconstruction,
                p.losses.latent,
                p.losses.patches,
                p.losses.responses,
                p.losses.features,
                p.pace,
                left / 60.0
            ));
        }
    }
}

fn summary(card: &Card) -> String {
    let m = &card.held_out;
    format!(
        "on {} tiles held out: reconstruction error {:.2} of the relief, latent distance {:.3} (chance {:.3}), spectrum within {:.1} dB; \
         slopes p50/p95/p99 {:.1}/{:.1}/{:.1} deg, drawn {:.1}/{:.1}/{:.1}; power k^{:.2}, drawn k^{:.2}",
        m.tiles,
        m.reconstruction_error,
        m.latent_distance,
        m.latent_distance_of_chance,
        m.spectrum_db,
        m.real.slope_deg[0],
        m.real.slope_deg[2],
        m.real.slope_deg[3],
        m.drawn.slope_deg[0],
        m.drawn.slope_deg[2],
        m.drawn.slope_deg[3],
        m.real.exponent,
        m.drawn.exponent
    )
}

/// A line to stderr; a reader that went away doesn't matter.
fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
