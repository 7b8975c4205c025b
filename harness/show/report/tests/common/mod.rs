//! Runs as tests write them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use vb_record::{
    DataHeader, LogMode, PluginHeader, PluginKind, RUN_SCHEMA, RulesHeader, RunHeader, RunStore, SuiteHeader,
    TraceMode,
};
use vb_score::{Cause, Conditions, FuelUse, Metrics, Outcome, TaskRecord};
use vb_world::{Density, Elevation, Terrain};

/// Text of a planner that would like to be markup.
pub const HOSTILE: &str =
    "</script><script>document.title='owned'</script><img src=x onerror=\"document.title='owned'\">";

/// What a run of so many tasks says of itself.
pub fn header(name: &str, tasks: u64) -> RunHeader {
    RunHeader {
        schema: RUN_SCHEMA,
        harness_version: "0.1.0".into(),
        harness_commit: "unknown".into(),
        started_at: "2026-01-01T00:00:00Z".into(),
        suite: SuiteHeader { name: "s".into(), hash: "aa".repeat(32), path: "tasks/s".into(), tasks },
        selector: None,
        shard: None,
        tasks,
        plugin: PluginHeader {
            name: name.into(),
            version: "1.0.0".into(),
            sha256: "bb".repeat(32),
            kind: PluginKind::Wasm,
            path: "p.wasm".into(),
            control_period: 0.1,
            eligible_for_ranking: true,
            sensors: Vec::new(),
            sandbox: None,
        },
        params: BTreeMap::new(),
        vehicle: Conditions::standard().vehicle.clone(),
        soils: Conditions::standard().soils.clone(),
        perception: DataHeader { name: "oracle".into(), hash: "ee".into() },
        scale: 1.0,
        seed: 0,
        time_step: 0.001,
        soil_resolution: 0.1,
        sample_period: 0.01,
        rules: RulesHeader {
            name: "paper".into(),
            hash: Conditions::standard().rules.hash.clone(),
            profile: serde_json::json!({}),
        },
        limits: BTreeMap::from([("memory_bytes".into(), 1 << 28)]),
        trace: TraceMode::TenHz,
        logs: LogMode::default(),
    }
}

/// Task `t` of world `w`, which ends well if `success`.
pub fn record(w: usize, t: usize, success: bool) -> TaskRecord {
    let x = ((w * 7 + t * 3) % 11) as f64;
    let outcome = if success { Outcome::Success } else { Outcome::Stuck };
    TaskRecord {
        task: format!("w{w:03}/t{t:02}").parse().unwrap(),
        world: format!("w{w:03}"),
        elevation: Elevation::ALL[w % 3],
        terrain: Terrain::ALL[w / 3 % 3],
        density: Density::ALL[w / 9 % 3],
        outcome,
        three_way: outcome.three_way(false),
        flags: std::collections::BTreeMap::new(),
        departures: Vec::new(),
        reason: "because".into(),
        cause: (!success).then_some(if t.is_multiple_of(3) {
            Cause::HighCentred
        } else {
            Cause::SpinningOnSoil
        }),
        evidence: String::new(),
        fault: None,
        time_s: 20.0 + x,
        state_hash: "0123456789abcdef".into(),
        sim_steps: 100,
        planner_steps: 10,
        clamped: 1,
        fuel: Some(FuelUse::new(5, vec![1, 2, 3], 100, 100, 65536)),
        metrics: Some(Metrics {
            samples: 1000 + 100 * t as u64,
            roll_mean_deg: x,
            roll_variance_deg2: 1.0,
            roll_max_deg: 3.0 * x,
            pitch_mean_deg: 0.5 * x,
            pitch_variance_deg2: 0.5,
            pitch_max_deg: x,
            distance_m: 100.0,
            speed_mean_m_per_s: 4.0,
            goal_distance_end_m: 6.0,
            ..Metrics::default()
        }),
        ride: None,
        log: Vec::new(),
        backtrace: Vec::new(),
    }
}

pub fn write(dir: &Path, header: &RunHeader, records: impl IntoIterator<Item = TaskRecord>) -> PathBuf {
    let store = RunStore::create(dir, header).unwrap();
    records.into_iter().for_each(|r| store.append(&r).unwrap());
    dir.to_owned()
}

/// All tasks of `worlds` worlds of four tasks, of which those succeed that `success` says.
pub fn tasks(worlds: usize, success: impl Fn(usize, usize) -> bool) -> Vec<TaskRecord> {
    let mut all = Vec::new();
    for w in 0..worlds {
        all.extend((0..4).map(|t| record(w, t, success(w, t))));
    }
    all
}
