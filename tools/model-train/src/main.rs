//! `vb-model-train`: datasets in, weights and their card out.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use serde_json::json;
use vb_model_train::TrainError;
use vb_model_train::data::{Data, Moment, Window};
use vb_model_train::measure::{Measured, WAYS, measure};
use vb_model_train::model::Motion;
use vb_model_train::network::Dense;
use vb_model_train::sight::Sight;
use vb_model_train::train::train;
use vb_sdk::nn::Weights;

/// Train the model of motion of the hybrid planners on datasets of exploration
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// Datasets that `vb-harness dataset explore` has made
    #[arg(long, value_name = "DIR", required = true, num_args = 1..)]
    data: Vec<PathBuf>,
    /// File of the vehicle
    #[arg(long, value_name = "FILE", default_value = "tasks/vehicles/hmmwv.yaml")]
    vehicle: PathBuf,
    /// Where the weights go; their card goes beside them as .json, and what metadata of plugins say of them as .txt
    #[arg(long, value_name = "FILE", required_unless_present = "measure")]
    out: Option<PathBuf>,
    /// Begin with these weights
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Only measure these weights
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    measure: Option<PathBuf>,
    /// What of the ground the networks see: the patch about the vehicle, or also those ahead, to which they pay attention
    #[arg(long, value_enum, default_value_t = Look::Patch)]
    sight: Look,
    /// Steps of training
    #[arg(long, value_name = "N", default_value_t = 6000)]
    steps: usize,
    /// Names all random draws
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Look {
    Patch,
    Attention,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            note(&format!("error: {e}"));
            ExitCode::from(match e {
                TrainError::Write { .. } => 4,
                TrainError::Tensor(_) => 1,
                _ => 3,
            })
        }
    }
}

fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

fn vehicle(args: &Args) -> Result<vb_sdk::Vehicle, TrainError> {
    let wrong = |e: &dyn std::fmt::Display| TrainError::Vehicle(format!("{}: {e}", args.vehicle.display()));
    let text = vb_files::read_text(&args.vehicle, vb_files::DOCUMENT).map_err(|e| wrong(&e))?;
    let spec =
        vb_vehicle::VehicleSpec::parse(&text, &args.vehicle.display().to_string()).map_err(|e| wrong(&e))?;
    let scale = spec.scale;
    let own = vb_vehicle::Vehicle { spec, hash: String::new() };
    let soils = vb_sim::Soils { set: vb_sim::SoilSet::default(), hash: String::new(), resolution: 0.1 };
    let rules = vb_score::Rules::resolve("exploration").map_err(|e| wrong(&e))?;
    let oracle = vb_sense::Profile::oracle();
    let setting =
        vb_trial::Setting::new(&own, &soils, &rules, &oracle, 0.001, scale, 0).map_err(|e| wrong(&e))?;
    Ok(setting.vehicle)
}

fn run(args: &Args) -> Result<(), TrainError> {
    let vehicle = vehicle(args)?;
    let data = Data::of(&args.data, &vehicle)?;
    // Every fifth world is held out, by its hash, so that it stays the same whatever else there is.
    let held_out = |w: &Window| u8::from_str_radix(&data.places[w.place].hash[..2], 16).unwrap_or(0) % 5 == 0;
    let (test, own): (Vec<&Window>, Vec<&Window>) = data.windows.iter().partition(|w| held_out(w));
    let (unseen, watched): (Vec<&Moment>, Vec<&Moment>) =
        data.moments.iter().partition(|m| held_out(&m.window));
    note(&format!(
        "{} windows in {} worlds; {} windows are held out",
        own.len(),
        data.places.len(),
        test.len()
    ));
    let weights = match &args.measure {
        Some(path) => read(path)?,
        None => trained(args, &vehicle, &data, (&own, &watched))?,
    };
    let moving: Vec<&Window> = test.iter().copied().filter(|w| !w.stands).collect();
    let measured = measure(&weights, &vehicle, &data, (&moving, &unseen))?;
    tell(&measured);
    let Some(out) = &args.out else { return Ok(()) };
    let bytes = weights.bytes();
    let write = |path: &Path, bytes: &[u8]| {
        std::fs::write(path, bytes).map_err(|source| TrainError::Write { path: path.to_owned(), source })
    };
    write(out, &bytes)?;
    let hash = vb_files::sha256(&bytes);
    let errors = measured.errors.iter().map(|(kind, ways)| {
        let own = WAYS.iter().zip(ways).map(|(way, errors)| ((*way).to_owned(), json!(errors)));
        (kind.clone(), own.collect::<serde_json::Map<_, _>>())
    });
    let card = json!({
        "weights_sha256": hash,
        "vehicle": vehicle.name,
        "frames_sha256": data.hashes,
        "sight": weights.note("sight"),
        "seed": args.seed,
        "steps": args.steps,
        "windows": own.len(),
        "windows_held_out": test.len(),
        "errors_in_worlds_held_out": errors.collect::<BTreeMap<_, _>>(),
        "hazards_in_worlds_held_out": {"stuck": measured.hazards[0], "over": measured.hazards[1]},
    });
    let text = serde_json::to_string_pretty(&card).expect("the card has text keys") + "\n";
    write(&out.with_extension("json"), text.as_bytes())?;
    // What plugins that embed the weights say of them in their metadata.
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    let said = format!("{name} sha256 {hash}, learned from frames sha256 {}", data.hashes.join(" "));
    write(&out.with_extension("txt"), said.as_bytes())?;
    note(&format!("{} is written", out.display()));
    Ok(())
}

fn read(path: &Path) -> Result<Weights, TrainError> {
    let bytes = vb_files::read(path, vb_files::DOCUMENT).map_err(|e| TrainError::Weights(e.to_string()))?;
    Weights::parse(&bytes).map_err(|e| TrainError::Weights(format!("{}: {e}", path.display())))
}

/// New weights, trained on these windows and moments.
fn trained(
    args: &Args,
    vehicle: &vb_sdk::Vehicle,
    data: &Data,
    own: (&[&Window], &[&Moment]),
) -> Result<Weights, TrainError> {
    let sight = match args.sight {
        Look::Patch => Sight::patch(args.seed)?,
        Look::Attention => Sight::attention(args.seed)?,
    };
    let model = Motion::new(vehicle, sight, data.timing.step(), args.seed)?;
    let begun = args.from.as_deref().map(read).transpose()?;
    for network in model.networks() {
        begun.iter().try_for_each(|begun| network.begin_with(begun))?;
    }
    train(&model, data, own, args.steps, args.seed, |step, loss| {
        note(&format!("step {step}: loss {loss:.4}"))
    })?;
    let notes = [
        ("vehicle", vehicle.name.clone()),
        ("frames", data.hashes.join(" ")),
        ("seed", args.seed.to_string()),
        ("steps", args.steps.to_string()),
        ("sight", model.sight.name().to_owned()),
        ("begun with", begun.map_or_else(|| "nothing".to_owned(), |begun| vb_files::sha256(&begun.bytes()))),
    ];
    let layers = model.networks().into_iter().map(Dense::layers);
    Ok(Weights {
        notes: notes.into_iter().map(|(k, v)| (k.to_owned(), v)).collect(),
        layers: layers.collect::<Result<Vec<_>, _>>()?.concat(),
    })
}

/// Says how good weights are.
fn tell(measured: &Measured) {
    for (kind, ways) in &measured.errors {
        for (way, e) in WAYS.iter().zip(ways).flat_map(|(way, errors)| errors.iter().map(move |e| (way, e))) {
            note(&format!(
                "{kind:10} {way:18} {:.2} s: {:.3} m, {:.3} rad, {:.3} m/s, roll {:.2} deg, pitch {:.2} deg",
                e.time_s,
                e.position_m,
                e.yaw_rad,
                e.speed_m_per_s,
                e.roll_rad.to_degrees(),
                e.pitch_rad.to_degrees()
            ));
        }
    }
    for (name, h) in ["stuck", "over"].iter().zip(&measured.hazards) {
        note(&format!("{name}: comes after {:.2} % of moments, AUC {:.3}", 100.0 * h.rate, h.auc));
        for (p, c, n) in &h.calibration {
            note(&format!("  foreseen {p:.3}, came {c:.3} ({n})"));
        }
    }
}
