//! Tasks of `smoke` driven by nodes, and their records.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use vb_host::{FaultCode, Limits, Plugin, PluginKind};
use vb_record::{LogMode, RunReader, TraceMode};
use vb_ros::{Options, Pace};
use vb_rosmsg::messages::geometry_msgs::TwistStamped;
use vb_runner::{RunConfig, run};
use vb_score::{Rules, TaskRecord};
use vb_sense::Profile;
use vb_sim::{SoilSet, Soils};
use vb_vehicle::{Vehicle, VehicleSpec};
use vb_world::{Suite, TaskId, WorldInfo};

use crate::interop::{Planner, Twin, python};
use crate::peer::{Peer, alone, domain, options, plugin, stamped};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// The records of a planner over some tasks of `smoke`.
fn records(plugin: Plugin, out: &Path, tasks: &[TaskId]) -> Vec<TaskRecord> {
    let tasks_dir = root().join("tasks");
    let soils = std::fs::read_to_string(tasks_dir.join("soils/default.yaml")).unwrap();
    let config = RunConfig {
        suite: Suite::open(tasks_dir.join("smoke")).unwrap(),
        tasks: tasks.to_vec(),
        selector: None,
        shard: None,
        plugin,
        plugin_path: "ros".into(),
        params: Vec::new(),
        vehicle: Vehicle {
            spec: VehicleSpec::load(&tasks_dir.join("vehicles/hmmwv.yaml")).unwrap(),
            hash: String::new(),
        },
        soils: Soils {
            set: SoilSet::parse(&soils, "default.yaml").unwrap(),
            hash: String::new(),
            resolution: 0.1,
        },
        perception: Profile::load(&tasks_dir.join("perception/oracle.yaml")).unwrap(),
        rules: Rules::resolve("paper").unwrap(),
        time_step: 0.001,
        scale: 1.0,
        seed: 0,
        jobs: 1,
        trace: TraceMode::None,
        logs: LogMode::All,
        out: out.to_owned(),
        resume: false,
        keep_going: true,
        started_at: String::new(),
        harness_version: String::new(),
        harness_commit: String::new(),
    };
    run(&config, &mut |_| {}, &AtomicBool::new(false)).unwrap();
    RunReader::open(out).unwrap().records().unwrap()
}

/// Number of tasks, evenly chosen from the suite.
const TASKS: usize = 2;

#[test]
fn a_planner_on_cyclone_dds_gets_the_record_of_the_same_planner_in_rust() {
    let _alone = alone();
    let Some(python) = python() else { return };
    let suite = Suite::open(root().join("tasks/smoke")).unwrap();
    let all: Vec<TaskId> = suite.worlds().iter().flat_map(WorldInfo::task_ids).collect();
    let places = all.iter().enumerate().map(|(k, id)| (id.to_string(), k)).collect();
    let tasks: Vec<TaskId> = all.iter().step_by(all.len().div_ceil(TASKS)).cloned().collect();
    let options = Options { places, ..options() };
    let twin = Plugin::external(
        PluginKind::Ros,
        plugin(options.clone()).metadata().clone(),
        "twin",
        &Limits::default(),
        Arc::new(Twin),
    );
    let folder = tempfile::tempdir().unwrap();
    let wanted = records(twin, &folder.path().join("rust"), &tasks);
    let _planner = Planner::start(python, &[]);
    let found = records(plugin(options), &folder.path().join("cyclone"), &tasks);
    assert_eq!(wanted.len(), tasks.len());
    for (wanted, found) in wanted.iter().zip(&found) {
        assert_eq!(found.fault, None, "{}: {:?}", found.task, found.reason);
        assert_eq!((&found.task, &found.outcome), (&wanted.task, &wanted.outcome));
        assert_eq!(found.state_hash, wanted.state_hash, "{}", found.task);
        assert!(found.planner_steps > 20, "{}: {} steps", found.task, found.planner_steps);
    }
}

#[test]
fn records_of_the_real_time_mode_are_marked() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        for _ in 0..3 {
            let Some(time) = hands.tick() else { return };
            commands.publish(stamped(time, 1.0, 0.0)).unwrap();
        }
    });
    let folder = tempfile::tempdir().unwrap();
    let options = Options { pace: Pace::RealTime { deadline: 0.1 }, ..options() };
    let task = "w001/t00".parse().unwrap();
    let found = records(plugin(options), folder.path(), &[task]);
    assert_eq!(found[0].fault, Some(FaultCode::Crashed), "{:?}", found[0].reason);
    let marks = &found[0].departures;
    assert_eq!(
        marks.last().unwrap(),
        "real time: the deadline of commands was 0.1 s of wall-clock time",
        "{marks:?}"
    );
}
