//! Files that a vehicle's file does not name: engine, transmission and tyres.

use super::json::{Doc, Node};
use super::set::Set;
use super::{powertrain, tyre};
use crate::{ImportError, Notes, Options};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use vb_vehicle::powertrain::Engine;

/// The powertrain's parts.
pub(super) struct Powertrain {
    pub(super) engine: Engine,
    pub(super) transmission: powertrain::Transmission,
}

/// The options with the files that a vehicle's file names where the user gives none.
pub(super) fn named(
    set: &Set,
    root: &Node,
    options: &Options,
    notes: &mut Notes,
) -> Result<Options, ImportError> {
    let mut out = options.clone();
    let place = |n: Option<Node>| n.map(|n| set.place(&n)).transpose();
    if let Some(p) = root.get("Powertrain") {
        let whole = place(p.get("Input File"))?;
        let engine = place(p.get("Engine Input File"))?.or_else(|| whole.clone());
        let transmission = place(p.get("Transmission Input File"))?.or(whole);
        let given = [&out.engine, &out.transmission].into_iter().flatten().next().is_some();
        if given {
            notes.chosen(format!("{}: replaced by the given files", p.at()));
        }
        out.engine = out.engine.or(engine);
        out.transmission = out.transmission.or(transmission);
    }
    let mut tyres = vec![place(root.get("Tire").and_then(|t| t.get("Input File")))?];
    if let Some(axles) = root.get("Axles") {
        tyres = axles.items()?.iter().map(|a| place(a.get("Tire Input File"))).collect::<Result<_, _>>()?;
    }
    let first = tyres.iter().flatten().next().cloned();
    if let Some(first) = first
        && out.tyres.is_empty()
    {
        out.tyres = tyres.into_iter().map(|t| t.unwrap_or_else(|| first.clone())).collect();
    }
    Ok(out)
}

/// Templates of powertrains of Chrono 8 and before, the preferred one first.
const WHOLE: &[&str] =
    &["ShaftsPowertrain", "SimpleMapPowertrain", "SimpleCVTPowertrain", "SimplePowertrain"];

/// Reads engine and transmission, chosen by the user or from the set: those with shafts if there are both, as in Chrono's own
/// demonstrations, else those with maps, else simple ones.
pub(super) fn powertrain(set: &Set, options: &Options, notes: &mut Notes) -> Result<Powertrain, ImportError> {
    let (engines, transmissions) = (set.find("Engine"), set.find("Transmission"));
    let has = |list: &[(PathBuf, String)], template: &str| list.iter().any(|(_, t)| t == template);
    let none_given = options.engine.is_none() && options.transmission.is_none();
    let shafts =
        has(&engines, "EngineShafts") && has(&transmissions, "AutomaticTransmissionShafts") && none_given;
    let engine_order: &[&str] =
        if shafts { &["EngineShafts"] } else { &["EngineSimpleMap", "EngineShafts", "EngineSimple"] };
    let transmission_order: &[&str] = if shafts {
        &["AutomaticTransmissionShafts"]
    } else {
        &[
            "AutomaticTransmissionSimpleMap",
            "AutomaticTransmissionShafts",
            "ManualTransmissionShafts",
            "AutomaticTransmissionSimpleCVT",
        ]
    };
    let whole = set.find("Powertrain");
    let found = WHOLE.iter().find_map(|t| whole.iter().find(|(_, template)| template == t));
    let engine = match &options.engine {
        Some(path) => set.load(path, &["Engine", "Powertrain"])?,
        None => match found.filter(|_| none_given && (engines.is_empty() || transmissions.is_empty())) {
            Some((path, _)) => {
                told(set, path, &whole, "--engine", notes);
                set.load(path, &["Powertrain"])?
            }
            None => pick(set, "Engine", "--engine", &engines, engine_order, notes)?,
        },
    };
    let is_whole = super::set::kind(&engine)? == "Powertrain";
    let transmission = match &options.transmission {
        Some(path) => set.load(path, &["Transmission", "Powertrain"])?,
        None if is_whole => engine.clone(),
        None => pick(set, "Transmission", "--transmission", &transmissions, transmission_order, notes)?,
    };
    let mut engine = powertrain::engine(&engine, notes)?;
    let transmission = powertrain::transmission(&transmission, &engine, notes)?;
    match &mut engine {
        Engine::Map { inertia, .. } | Engine::Simple { inertia, .. } | Engine::Electric { inertia, .. } => {
            *inertia += transmission.engine_inertia;
        }
    }
    Ok(Powertrain { engine, transmission })
}

/// The file of the first template of this order.
fn pick(
    set: &Set,
    kind: &str,
    option: &str,
    found: &[(PathBuf, String)],
    order: &[&str],
    notes: &mut Notes,
) -> Result<Rc<Doc>, ImportError> {
    let best = order.iter().find_map(|t| found.iter().find(|(_, template)| template == t));
    let Some((path, _)) = best else {
        let problem = format!(
            "no file with \"Type\": \"{kind}\" that has a counterpart ({}), and the vehicle's file names none; give it with {option}",
            order.join(", ")
        );
        return Err(ImportError::new(set.own.display(), "", problem));
    };
    told(set, path, found, option, notes);
    set.load(path, &[kind])
}

fn told(set: &Set, path: &Path, found: &[(PathBuf, String)], option: &str, notes: &mut Notes) {
    let others: Vec<String> = found.iter().filter(|(p, _)| p != path).map(|(p, _)| set.short(p)).collect();
    let rest = if others.is_empty() {
        String::new()
    } else {
        format!(" (others for {option}: {})", others.join(", "))
    };
    notes.chosen(format!("{}, which the vehicle's file does not name{rest}", set.short(path)));
}

/// The files of the tyres, one per axle.
pub(super) fn tyres(
    set: &Set,
    options: &Options,
    axles: usize,
    notes: &mut Notes,
) -> Result<Vec<Rc<Doc>>, ImportError> {
    if !options.tyres.is_empty() {
        let count = options.tyres.len();
        if count != 1 && count != axles {
            let problem = format!(
                "--tyre given {count} times; give it once for all axles or once for each of the {axles}"
            );
            return Err(ImportError::new(set.own.display(), "", problem));
        }
        return (0..axles)
            .map(|k| set.load(&options.tyres[if count == 1 { 0 } else { k }], &["Tire"]))
            .collect();
    }
    let found = set.find("Tire");
    let of = |t: &str| {
        found.iter().filter(|(_, template)| template == t).map(|(p, _)| p.clone()).collect::<Vec<_>>()
    };
    let Some(files) = tyre::TEMPLATES.iter().map(|t| of(t)).find(|f| !f.is_empty()) else {
        let problem = format!(
            "no file with \"Type\": \"Tire\" that has a counterpart ({}), and the vehicle's file names none; give them with --tyre",
            tyre::TEMPLATES.join(", ")
        );
        return Err(ImportError::new(set.own.display(), "", problem));
    };
    let named = |word: &str| {
        files
            .iter()
            .find(|f| f.file_name().is_some_and(|n| n.to_string_lossy().to_ascii_lowercase().contains(word)))
    };
    let (front, rear) = match (named("front"), named("rear")) {
        (Some(f), Some(r)) => (f, r),
        _ => (&files[0], &files[0]),
    };
    for path in if front == rear { vec![front] } else { vec![front, rear] } {
        told(set, path, &found, "--tyre", notes);
    }
    (0..axles).map(|k| set.load(if k == 0 { front } else { rear }, &["Tire"])).collect()
}
