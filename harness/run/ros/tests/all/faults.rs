//! Each thing that can go wrong with a node has one outcome.

use std::time::Duration;

use ros2_client::qos::QosProfile;
use vb_host::{FaultCode, LogSink};
use vb_ros::Options;
use vb_rosmsg::messages::geometry_msgs::{Twist, TwistStamped};
use vb_rosmsg::messages::std_msgs::Int8;

use crate::peer::{Peer, alone, domain, fault, options, plugin, reliable, stamped, start, task, twist};

/// Options under which a test that waits for a time-out ends soon.
fn impatient() -> Options {
    Options { start_timeout: Duration::from_secs(2), answer_timeout: Duration::from_secs(2), ..options() }
}

#[test]
fn without_a_node_a_task_does_not_start() {
    let _alone = alone();
    let (code, said) = fault(impatient());
    assert_eq!(code, FaultCode::Hung);
    let wanted = format!(
        "init: no node publishes on /cmd_vel or /ackermann_cmd, or calls /vertibench/step, in domain {} on 127.0.0.1 within 2 s",
        domain()
    );
    assert_eq!(said, wanted);
}

#[test]
fn a_node_in_another_domain_is_not_there() {
    let _alone = alone();
    let _peer = Peer::answering(domain() - 1, 1.0, 0.0);
    let (code, said) = fault(impatient());
    assert!(code == FaultCode::Hung && said.starts_with("init: no node publishes"), "{said}");
}

#[test]
fn a_node_that_leaves_has_crashed() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        for _ in 0..3 {
            let Some(time) = hands.tick() else { return };
            commands.publish(stamped(time, 1.0, 0.0)).unwrap();
        }
        let _ = hands.tick();
    });
    let (code, said) = fault(options());
    assert_eq!(code, FaultCode::Crashed, "{said}");
    assert_eq!(said, "step 3 (t = 0.30 s): the node that published commands left the domain");
}

#[test]
fn a_node_that_floods_is_stopped() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        // All of them are for a time before the task, so no tick is answered.
        while hands.goes_on() {
            let _ = commands.publish(stamped(1, 1.0, 0.0));
        }
    });
    let (code, said) = fault(options());
    assert_eq!(code, FaultCode::Protocol, "{said}");
    assert!(said.contains("more than 1000 messages within one tick, the last on /cmd_vel"), "{said}");
}

#[test]
fn a_command_that_is_not_a_number_is_invalid() {
    let _alone = alone();
    let _peer = Peer::answering(domain(), 1.0, f64::NAN);
    let (code, said) = fault(options());
    assert_eq!(code, FaultCode::InvalidOutput);
    assert_eq!(said, "step 0 (t = 0.00 s): angular.z is NaN; a command must be finite");
}

#[test]
fn a_topic_of_another_type_or_reliability_is_named() {
    let _alone = alone();
    let says = |package: &'static str, name: &'static str, qos: QosProfile| {
        let _peer = Peer::start(domain(), move |hands| {
            let _commands = hands.publisher_of::<u8>("/cmd_vel", package, name, &qos);
            hands.wait_for_the_end();
        });
        let (code, said) = fault(options());
        assert_eq!(code, FaultCode::Protocol, "{said}");
        said
    };
    assert_eq!(
        says("std_msgs", "UInt8", reliable()),
        "init: a node publishes /cmd_vel as std_msgs/msg/UInt8; it must be geometry_msgs/msg/Twist or geometry_msgs/msg/TwistStamped"
    );
    assert_eq!(
        says("geometry_msgs", "Twist", reliable().reliability_best_effort()),
        "init: a node publishes /cmd_vel as best effort; commands must be reliable"
    );
}

#[test]
fn bytes_that_are_not_the_type_that_they_claim_are_refused() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher_of::<u8>("/cmd_vel", "geometry_msgs", "Twist", &reliable());
        while hands.tick().is_some() {
            commands.publish(7).unwrap();
        }
    });
    let (code, said) = fault(options());
    assert_eq!(code, FaultCode::Protocol, "{said}");
    assert!(said.starts_with("step 0 (t = 0.00 s): a message on /cmd_vel can't be read: "), "{said}");
}

#[test]
fn answers_to_earlier_ticks_are_no_answers() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        while let Some(time) = hands.tick() {
            // The first tick is answered, all others as late as the clock before.
            let first = time % 1_000_000_000_000 == 0;
            commands.publish(stamped(if first { time } else { time - 100_000_000 }, 1.0, 0.0)).unwrap();
        }
    });
    let (code, said) = fault(impatient());
    assert_eq!(code, FaultCode::Hung, "{said}");
    assert!(
        said.starts_with("step 1 (t = 0.10 s): no command answered the tick at t = 0.10 s within 2 s"),
        "{said}"
    );
    assert!(said.ends_with("; commands for earlier ticks: 1"), "{said}");
}

#[test]
fn a_command_from_the_future_tells_of_a_clock_that_is_not_used() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let commands = hands.publisher::<TwistStamped>("/cmd_vel");
        while hands.tick().is_some() {
            commands.publish(stamped(1_700_000_000_000_000_000, 1.0, 0.0)).unwrap();
        }
    });
    let (code, said) = fault(options());
    assert_eq!(code, FaultCode::Protocol);
    assert_eq!(
        said,
        "step 0 (t = 0.00 s): a command is stamped 1700000000.000 s, which is after the time on /clock, 10000.000 s (set use_sim_time \
         on the node)"
    );
}

#[test]
fn a_gear_that_there_is_not_is_refused() {
    let _alone = alone();
    let _peer = Peer::start(domain(), |hands| {
        let gears = hands.publisher::<Int8>("/gear");
        let commands = hands.publisher::<Twist>("/cmd_vel");
        while hands.tick().is_some() {
            gears.publish(Int8 { data: 4 }).unwrap();
            std::thread::sleep(Duration::from_millis(20));
            commands.publish(twist(1.0, 0.0)).unwrap();
        }
    });
    let (code, said) = fault(options());
    assert_eq!(code, FaultCode::Protocol);
    assert!(
        said.ends_with("a message on /gear is 4; it must be -1 (reverse), 0 (neutral) or 1 (forward)"),
        "{said}"
    );
}

#[test]
fn one_task_at_a_time_has_the_node() {
    let _alone = alone();
    let _peer = Peer::answering(domain(), 1.0, 0.0);
    let plugin = plugin(options());
    let first = start(&plugin).unwrap();
    let second = start(&plugin).unwrap_err();
    assert_eq!(second.code(), FaultCode::Worker);
    drop(first);
    // After a failure, too, the next task can have it.
    plugin.start(&task("w001/t01"), LogSink::discard()).unwrap();
}
