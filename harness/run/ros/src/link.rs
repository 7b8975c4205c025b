//! The node of the harness: its endpoints, and the nodes discovered in the network.

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use ros2_client::qos::{Durability, History, QosProfile, WhenFull};
use ros2_client::{
    Context, Gid, MessageInfo, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, ReadError,
    RmwRequestId, Server, ServiceMapping, ServiceTypeName, Subscription, WriteError,
};
use rustdds::mio1::event::Source;
use rustdds::mio1::{Events, Interest, Poll, Token};
use rustdds::policy::Reliability;
use rustdds::{DomainParticipant, DomainParticipantBuilder, GUID};
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use vb_host::FaultCause;
use vb_rosmsg::Message;
use vb_rosmsg::convert::time_nanoseconds;
use vb_rosmsg::messages::ackermann_msgs::{AckermannDrive, AckermannDriveStamped};
use vb_rosmsg::messages::geometry_msgs::{PoseStamped, Twist, TwistStamped};
use vb_rosmsg::messages::grid_map_msgs::GridMap;
use vb_rosmsg::messages::nav_msgs::{OccupancyGrid, Odometry, Path};
use vb_rosmsg::messages::rosgraph_msgs::Clock;
use vb_rosmsg::messages::sensor_msgs::{CameraInfo, Image, Imu, JointState, NavSatFix, PointCloud2};
use vb_rosmsg::messages::std_msgs::{Int8, String as Text};
use vb_rosmsg::messages::tf2_msgs::TFMessage;
use vb_sdk::metadata::Sensor;

use crate::Options;

/// The topics from which commands are taken.
const VELOCITY: &str = "/cmd_vel";
const ACKERMANN: &str = "/ackermann_cmd";
const GEAR: &str = "/gear";
/// The service that advances the simulation by one tick: namespace and name.
const STEP: (&str, &str) = ("/vertibench", "step");
/// Messages of one topic that a reader keeps until they are taken.
const DEPTH: usize = 100;
/// The longest time that a full reader may block sending.
const SEND: Duration = Duration::from_secs(1);
/// Maximum number of messages within a tick; more are a flood.
const FLOOD: usize = 1000;
/// The vendor in the GUIDs of Cyclone DDS (OMG's list of vendors).
const CYCLONE: [u8; 2] = [0x01, 0x10];

/// The request of `std_srvs/srv/Trigger`; CDR has a byte for what is empty.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct TriggerRequest {
    structure_needs_at_least_one_member: u8,
}

/// The response of `std_srvs/srv/Trigger`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct TriggerResponse {
    success: bool,
    message: String,
}

impl ros2_client::Message for TriggerRequest {}
impl ros2_client::Message for TriggerResponse {}

/// A message as it came: plain CDR in little-endian byte order, with its header. All systems that ROS 2 supports have this order.
#[derive(Debug)]
struct Raw(Vec<u8>);

impl Raw {
    /// Bytes that are kept: a velocity with a name of its frame has some dozens.
    const MOST: usize = 64 << 10;
    /// Bytes of a `Twist`: six numbers after the header. A `TwistStamped` has at least 16 more.
    const TWIST: usize = 4 + 6 * 8;

    /// Whether it is a `Twist` and not a `TwistStamped`.
    fn is_twist(&self) -> bool {
        self.0.len() == Self::TWIST
    }

    fn read<M: Message>(&self, topic: &str) -> Result<M, FaultCause> {
        vb_rosmsg::from_cdr(&self.0).map_err(|e| unreadable(topic, &e))
    }
}

impl<'de> Deserialize<'de> for Raw {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct All;

        impl<'de> Visitor<'de> for All {
            type Value = Raw;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("bytes")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut bytes: A) -> Result<Raw, A::Error> {
                let mut all = vec![0, 1, 0, 0];
                // The end of the message is an error to who asks for one more.
                while all.len() < Raw::MOST
                    && let Ok(Some(byte)) = bytes.next_element::<u8>()
                {
                    all.push(byte);
                }
                Ok(Raw(all))
            }
        }

        deserializer.deserialize_tuple(Self::MOST, All)
    }
}

/// The fault that a message can't be read.
fn unreadable(topic: &str, reason: &dyn std::fmt::Display) -> FaultCause {
    let reason = vb_files::one_line(&reason.to_string());
    FaultCause::PeerProtocol { message: format!("a message on {topic} can't be read: {reason}") }
}

/// Messages received from other nodes.
#[derive(Debug)]
pub(crate) enum Incoming {
    /// A velocity, with the time that it is stamped with, ns; none for a message without a stamp.
    Twist(Option<i64>, Twist),
    Drive(Option<i64>, AckermannDrive),
    Gear(i8),
    /// A call of the service `step`, to be answered with [`Link::reply`].
    Step(StepCall),
}

/// A call of the service `step`.
#[derive(Debug)]
pub(crate) struct StepCall {
    server: usize,
    request: RmwRequestId,
}

/// The discovered nodes that publish commands or call `step`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Peers {
    /// The participants that can command.
    pub(crate) participants: BTreeSet<[u8; 12]>,
    /// All endpoints of these participants.
    pub(crate) endpoints: usize,
    /// Why an endpoint on a topic of commands can't be heard.
    pub(crate) unusable: Option<String>,
}

/// The publishers of the harness. Those of sensors that are not declared are absent.
pub(crate) struct Outgoing {
    pub(crate) clock: Publisher<Clock>,
    pub(crate) tf: Option<Publisher<TFMessage>>,
    pub(crate) tf_static: Publisher<TFMessage>,
    pub(crate) odometry: Option<Publisher<Odometry>>,
    pub(crate) joints: Option<Publisher<JointState>>,
    pub(crate) imu: Option<Publisher<Imu>>,
    pub(crate) fix: Option<Publisher<NavSatFix>>,
    pub(crate) points: Option<Publisher<PointCloud2>>,
    pub(crate) depth: Option<(Publisher<Image>, Publisher<CameraInfo>)>,
    pub(crate) map: Publisher<OccupancyGrid>,
    pub(crate) elevation_map: Publisher<GridMap>,
    pub(crate) plan: Publisher<Path>,
    pub(crate) goal: Publisher<PoseStamped>,
    pub(crate) description: Publisher<Text>,
    pub(crate) task: Publisher<Text>,
}

pub(crate) struct Link {
    participant: DomainParticipant,
    // The node must outlive its endpoints' last message; it is otherwise unused.
    _node: Node,
    poll: Poll,
    events: Events,
    pub(crate) out: Outgoing,
    /// Both hear all messages of their topic: RustDDS matches endpoints by topic alone.
    twist: Subscription<Raw>,
    twist_stamped: Subscription<Raw>,
    drive: Subscription<AckermannDriveStamped>,
    gear: Subscription<Int8>,
    /// One for each mapping of services to DDS: that of Fast DDS, and that of Cyclone DDS.
    step: [Server<TriggerRequest, TriggerResponse>; 2],
    inbox: VecDeque<Incoming>,
    /// Messages that came since [`Link::start_count`].
    came: usize,
    /// The nodes with which the last task began.
    pub(crate) known: Peers,
}

impl std::fmt::Debug for Link {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Link(domain {})", self.participant.domain_id())
    }
}

/// Messages that late nodes do not receive: sensors, clock and commands.
fn volatile() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Wait(SEND))
        .history(History::KeepLast { depth: DEPTH })
}

/// Messages of which late nodes receive the last one: maps, plan and goal.
fn latched() -> QosProfile {
    volatile().durability(Durability::TransientLocal).history(History::KeepLast { depth: 1 })
}

/// A failure of the library, which is the machine's: sockets, memory, threads.
fn machine(e: impl std::fmt::Display) -> FaultCause {
    FaultCause::Machine { message: format!("DDS: {e}") }
}

/// The name of an absolute topic.
fn topic_name(topic: &str) -> Result<Name, FaultCause> {
    Name::parse(topic).map_err(|e| machine(format!("{topic}: {e}")))
}

fn topic<M: Message>(node: &Node, name: &str, qos: &QosProfile) -> Result<rustdds::Topic, FaultCause> {
    node.create_topic(&topic_name(name)?, MessageTypeName::new(M::PACKAGE, M::TYPE), qos).map_err(machine)
}

fn publisher<M: Message>(node: &mut Node, name: &str, qos: &QosProfile) -> Result<Publisher<M>, FaultCause> {
    let topic = topic::<M>(node, name, qos)?;
    node.create_publisher(&topic, None).map_err(machine)
}

/// A subscription under the type name of `M`, whose messages are read as `D`.
fn subscription<M: Message, D: 'static>(node: &mut Node, name: &str) -> Result<Subscription<D>, FaultCause> {
    let topic = topic::<M>(node, name, &volatile())?;
    node.create_subscription(&topic, None).map_err(machine)
}

/// Sends a message. A reader that doesn't take it in time loses it.
pub(crate) fn send<M: Message>(publisher: &Publisher<M>, message: M) -> Result<(), FaultCause> {
    match publisher.publish(message) {
        Ok(()) | Err(WriteError::WouldBlock { .. }) => Ok(()),
        Err(e) => Err(machine(e)),
    }
}

impl Outgoing {
    fn new(node: &mut Node, options: &Options) -> Result<Self, FaultCause> {
        let (live, latched) = (volatile(), latched());
        fn if_any<M: Message>(
            wanted: bool,
            node: &mut Node,
            name: &str,
            qos: &QosProfile,
        ) -> Result<Option<Publisher<M>>, FaultCause> {
            wanted.then(|| publisher(node, name, qos)).transpose()
        }
        let has = |sensor| options.has(sensor);
        Ok(Self {
            clock: publisher(node, "/clock", &live)?,
            tf: if_any(has(Sensor::Pose), node, "/tf", &live)?,
            tf_static: publisher(node, "/tf_static", &latched)?,
            odometry: if_any(has(Sensor::Pose), node, "/odom", &live)?,
            joints: if_any(has(Sensor::WheelOdometry), node, "/joint_states", &live)?,
            imu: if_any(has(Sensor::Imu), node, "/imu/data", &live)?,
            fix: if_any(has(Sensor::Gnss), node, "/gps/fix", &live)?,
            points: if_any(has(Sensor::Lidar), node, "/points", &live)?,
            depth: if has(Sensor::Depth) {
                Some((
                    publisher(node, "/camera/depth", &live)?,
                    publisher(node, "/camera/camera_info", &live)?,
                ))
            } else {
                None
            },
            map: publisher(node, "/map", &latched)?,
            elevation_map: publisher(node, "/elevation_map", &latched)?,
            plan: publisher(node, "/plan", &latched)?,
            goal: publisher(node, "/goal_pose", &latched)?,
            description: publisher(node, "/robot_description", &latched)?,
            task: publisher(node, "/vertibench/task", &latched)?,
        })
    }
}

impl Link {
    /// Joins the domain as the node `/vertibench`.
    pub(crate) fn open(options: &Options) -> Result<Self, FaultCause> {
        let participant = DomainParticipantBuilder::new(options.domain)
            .with_only_networks(options.addresses())
            .build()
            .map_err(machine)?;
        let context = Context::from_domain_participant(participant.clone()).map_err(machine)?;
        let name = NodeName::new("/", "vertibench").map_err(machine)?;
        let mut node = context.new_node(name, NodeOptions::new().enable_rosout(false)).map_err(machine)?;
        let out = Outgoing::new(&mut node, options)?;
        let mut twist = subscription::<Twist, Raw>(&mut node, VELOCITY)?;
        let mut twist_stamped = subscription::<TwistStamped, Raw>(&mut node, VELOCITY)?;
        let mut drive = subscription::<AckermannDriveStamped, AckermannDriveStamped>(&mut node, ACKERMANN)?;
        let mut gear = subscription::<Int8, Int8>(&mut node, GEAR)?;
        let mut server = |mapping| {
            let name = Name::new(STEP.0, STEP.1).map_err(machine)?;
            let kind = ServiceTypeName::new("std_srvs", "Trigger");
            node.create_server(mapping, &name, &kind, volatile(), volatile()).map_err(machine)
        };
        let mut step = [server(ServiceMapping::Enhanced)?, server(ServiceMapping::Cyclone)?];
        let poll = Poll::new().map_err(machine)?;
        let [enhanced, cyclone] = &mut step;
        let sources: [&mut dyn Source; 6] =
            [&mut twist, &mut twist_stamped, &mut drive, &mut gear, enhanced, cyclone];
        for (k, source) in sources.into_iter().enumerate() {
            source.register(poll.registry(), Token(k), Interest::READABLE).map_err(machine)?;
        }
        Ok(Self {
            participant,
            _node: node,
            poll,
            events: Events::with_capacity(16),
            out,
            twist,
            twist_stamped,
            drive,
            gear,
            step,
            inbox: VecDeque::new(),
            came: 0,
            known: Peers::default(),
        })
    }

    /// Waits until something comes, for `limit` at most.
    pub(crate) fn wait(&mut self, limit: Duration) -> Result<(), FaultCause> {
        match self.poll.poll(&mut self.events, Some(limit)) {
            Err(e) if e.kind() != std::io::ErrorKind::Interrupted => Err(machine(e)),
            _ => Ok(()),
        }
    }

    /// Starts the count of messages: at most [`FLOOD`] may arrive between two calls.
    pub(crate) fn start_count(&mut self) {
        self.came = 0;
    }

    /// The next message: gears first, so that a gear that came with a command holds for it.
    pub(crate) fn next(&mut self) -> Result<Option<Incoming>, FaultCause> {
        if self.inbox.is_empty() {
            self.receive()?;
        }
        Ok(self.inbox.pop_front())
    }

    /// Takes all messages that are there.
    fn receive(&mut self) -> Result<(), FaultCause> {
        while let Some(gear) = taken(GEAR, self.gear.take())? {
            self.keep(GEAR, Incoming::Gear(gear.data))?;
        }
        while let Some(message) = taken(ACKERMANN, self.drive.take())? {
            self.keep(ACKERMANN, Incoming::Drive(stamp(&message.header.stamp), message.drive))?;
        }
        while let Some(raw) = taken(VELOCITY, self.twist_stamped.take())? {
            if !raw.is_twist() {
                let message = raw.read::<TwistStamped>(VELOCITY)?;
                self.keep(VELOCITY, Incoming::Twist(stamp(&message.header.stamp), message.twist))?;
            }
        }
        while let Some(raw) = taken(VELOCITY, self.twist.take())? {
            if raw.is_twist() {
                let twist = raw.read(VELOCITY)?;
                self.keep(VELOCITY, Incoming::Twist(None, twist))?;
            } else {
                // The other subscription has it, unless it is neither.
                raw.read::<TwistStamped>(VELOCITY)?;
            }
        }
        for server in 0..self.step.len() {
            loop {
                // Both mappings hear all requests; each can answer only its own.
                let request = match self.step[server].receive_request() {
                    Ok(None) => break,
                    Ok(Some((request, _))) => request,
                    Err(ReadError::Deserialization { .. }) => continue,
                    Err(e) => return Err(machine(e)),
                };
                let is_cyclone = request.writer_gid.as_bytes()[..2] == CYCLONE;
                if is_cyclone == (server == 1) {
                    self.keep("/vertibench/step", Incoming::Step(StepCall { server, request }))?;
                }
            }
        }
        Ok(())
    }

    /// Keeps a message until it is its turn. Too many are a fault.
    fn keep(&mut self, topic: &str, incoming: Incoming) -> Result<(), FaultCause> {
        self.came += 1;
        if self.came > FLOOD {
            return Err(FaultCause::PeerProtocol {
                message: format!("more than {FLOOD} messages within one tick, the last on {topic}"),
            });
        }
        self.inbox.push_back(incoming);
        Ok(())
    }

    /// Answers a call of `step`.
    pub(crate) fn reply(&self, call: &StepCall, message: String) -> Result<(), FaultCause> {
        let response = TriggerResponse { success: true, message };
        match self.step[call.server].send_response(call.request, response) {
            Ok(()) | Err(WriteError::WouldBlock { .. }) => Ok(()),
            Err(e) => Err(machine(e)),
        }
    }

    /// The discovered nodes that can command.
    pub(crate) fn peers(&self) -> Peers {
        /// Topics as DDS has them, each with its types; services have their own prefix.
        const HEARD: [(&str, &[&str]); 3] = [
            ("rt/cmd_vel", &["geometry_msgs::msg::dds_::Twist_", "geometry_msgs::msg::dds_::TwistStamped_"]),
            ("rt/ackermann_cmd", &["ackermann_msgs::msg::dds_::AckermannDriveStamped_"]),
            ("rq/vertibench/stepRequest", &["std_srvs::srv::dds_::Trigger_Request_"]),
        ];
        const GEARS: (&str, &[&str]) = ("rt/gear", &["std_msgs::msg::dds_::Int8_"]);
        let mut peers = Peers::default();
        let writers = self.participant.discovered_writers();
        for writer in &writers {
            let data = &writer.publication_topic_data;
            let commands = HEARD.iter().find(|(topic, _)| *topic == data.topic_name);
            let gears = Some(&GEARS).filter(|(topic, _)| *topic == data.topic_name);
            let Some((topic, types)) = commands.or(gears) else { continue };
            let shown = topic.trim_start_matches(['r', 't', 'q']);
            if !types.contains(&data.type_name.as_str()) {
                peers.unusable = Some(format!(
                    "a node publishes {shown} as {}; it must be {}",
                    ros_type(&data.type_name),
                    types.iter().map(|name| ros_type(name)).collect::<Vec<_>>().join(" or "),
                ));
            } else if !matches!(data.reliability, Some(Reliability::Reliable { .. })) {
                peers.unusable =
                    Some(format!("a node publishes {shown} as best effort; commands must be reliable"));
            } else if commands.is_some() {
                peers.participants.insert(prefix(data.key));
            }
        }
        let readers = self.participant.discovered_readers();
        let all = writers.iter().map(|w| w.publication_topic_data.key);
        let all = all.chain(readers.iter().map(|r| r.subscription_topic_data.key()));
        peers.endpoints = all.filter(|guid| peers.participants.contains(&prefix(*guid))).count();
        peers
    }
}

/// A participant's part of the identifier of an endpoint.
fn prefix(guid: GUID) -> [u8; 12] {
    let bytes = Gid::from(guid).to_bytes16();
    std::array::from_fn(|k| bytes[k])
}

/// A type as ROS names it, of its name on DDS.
fn ros_type(name: &str) -> String {
    let name = name.replacen("::dds_::", "::", 1).replace("::", "/");
    vb_files::one_line(name.strip_suffix('_').unwrap_or(&name))
}

/// The time of a header, ns; none for 0, with which nodes without a clock stamp.
fn stamp(time: &vb_rosmsg::messages::builtin_interfaces::Time) -> Option<i64> {
    Some(time_nanoseconds(time)).filter(|stamp| *stamp != 0)
}

/// A message that was taken, or the fault that it is.
fn taken<M>(
    topic: &str,
    result: Result<Option<(M, MessageInfo)>, ReadError>,
) -> Result<Option<M>, FaultCause> {
    result.map(|taken| taken.map(|(message, _)| message)).map_err(|e| match e {
        ReadError::Deserialization { reason } => unreadable(topic, &reason),
        e => machine(e),
    })
}
