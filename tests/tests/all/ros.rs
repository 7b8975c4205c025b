//! A planner that is a ROS 2 node: another process on another DDS implementation.

use std::process::{Child, Command};

use vb_tests::{Mini, root};

const TASKS: &str = "w001/t00,w002/t00";

/// A domain of this test. There are 233, of which people use the first.
fn domain() -> String {
    (100 + std::process::id() % 130).to_string()
}

/// The node, which ends with the test.
struct Node(Child);

impl Node {
    /// Starts `examples/ros2/pure_pursuit.py`; skips the test without `cyclonedds`.
    fn start() -> Option<Self> {
        let program = std::env::var("VB_PYTHON").unwrap_or_else(|_| "python3".into());
        let python = || {
            let mut command = Command::new(&program);
            command.env("PYTHONPATH", std::env::var_os("VB_PYTHON_LIBS").unwrap_or_default());
            command
        };
        let found = python().args(["-c", "import cyclonedds.domain"]).output();
        if !found.is_ok_and(|output| output.status.success()) {
            vb_testing::skip(format_args!(
                "{program} lacks cyclonedds (pip install cyclonedds, or set VB_PYTHON or VB_PYTHON_LIBS)"
            ));
            return None;
        }
        let script = root().join("examples/ros2/pure_pursuit.py");
        Some(Self(python().arg(script).args(["--domain", &domain(), "--seconds", "600"]).spawn().unwrap()))
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn ros<'a>(domain: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["ros", "--suite", "mini", "--domain", domain, "--name", "pure-pursuit"][..], more].concat()
}

#[test]
fn a_node_is_recorded_scored_and_replayed_as_other_planners() {
    let mini = Mini::new();
    let Some(node) = Node::start() else { return };
    let domain = domain();
    mini.ok(&ros(&domain, &["--tasks", TASKS, "--out", "run"]));
    let plugin = &mini.bench.json("run/run.json")["plugin"];
    assert_eq!(
        (&plugin["name"], &plugin["kind"], &plugin["eligible_for_ranking"]),
        (&"pure-pursuit".into(), &"ros".into(), &false.into())
    );
    let first = mini.bench.records("run");
    assert_eq!(first.len(), 2);
    for (task, record) in &first {
        assert_eq!(record["fault"], serde_json::Value::Null, "{task}: {record}");
        assert!(record["planner_steps"].as_u64().unwrap() > 20, "{task}: {record}");
    }
    // Nothing of a record depends on when answers come, nor on the task before.
    mini.ok(&ros(&domain, &["--tasks", "w002/t00", "--out", "again"]));
    assert_eq!(mini.bench.records("again")["w002/t00"]["state_hash"], first["w002/t00"]["state_hash"]);
    // `replay` simulates the recorded commands again and compares the state hash; the bag is a bag of ROS 2.
    mini.ok(&["replay", "run", "--task", "w001/t00", "--mcap", "task.mcap", "--profile", "ros2"]);
    assert!(std::fs::read(mini.path("task.mcap")).unwrap().starts_with(b"\x89MCAP0\r\n"));
    // Its commands drive the tasks again without the node, so that others can verify the result.
    mini.ok(&["commands", "run", "--out", "node.commands"]);
    mini.ok(&["run", "node.commands", "--suite", "mini", "--tasks", TASKS, "--out", "recorded"]);
    for (task, record) in &mini.bench.records("recorded") {
        assert_eq!(record["state_hash"], first[task]["state_hash"], "{task}");
    }
    mini.ok(&["submit", "node.commands", "--run", "recorded", "--out", "submission"]);
    assert_eq!(mini.bench.json("submission/submission.json")["division"], "open");
    mini.ok(&["verify", "submission", "--plugin", "node.commands"]);
    mini.ok(&["report", "run", "--out", "report"]);
    assert!(std::fs::read_to_string(mini.path("report/index.html")).unwrap().contains("pure-pursuit"));
    drop(node);
}

#[test]
fn without_a_node_the_run_stops_with_the_reason() {
    let mini = Mini::new();
    // No test has this domain.
    let said = mini.run(&ros("99", &["--out", "run", "--start-timeout", "500ms"])).error(10);
    assert!(said.contains("no node publishes on /cmd_vel or /ackermann_cmd"), "{said}");
    assert!(said.contains("in domain 99 on 127.0.0.1 within 0.5 s"), "{said}");
}

#[test]
fn options_of_the_network_are_checked_before_the_run() {
    let mini = Mini::new();
    let says = |more: &[&str]| mini.run(&ros("99", &[&["--out", "run"], more].concat())).error(2);
    assert!(
        says(&["--interface", "192.0.2.1"]).contains("no network interface of this machine has this address")
    );
    assert!(says(&["--sensor", "imu"]).contains("need pose or wheel-odometry"));
    assert!(says(&["--real-time", "--deadline", "1s"]).contains("at most the control period"));
    assert!(says(&["--datum", "91,0,0"]).contains("datum 91,0,0"));
    let mut command = mini.command(&["ros", "--suite", "mini", "--out", "run"]);
    let said = vb_tests::Done::of(command.env("ROS_DOMAIN_ID", "many")).error(2);
    assert!(said.contains("ROS_DOMAIN_ID is many: want a number from 0 to 232"), "{said}");
    assert!(!mini.path("run").exists());
}
