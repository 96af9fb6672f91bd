//! Prints the messages of a circumspect node, one JSON line each.

use std::thread::sleep;
use std::time::{Duration, Instant};

use ros2_client::{
    qos::Durability, Message, MessageTypeName, Node, NodeEvent, QosProfile, Subscription,
};

use crate::messages::*;
use crate::node::subscription;

struct Subscriptions {
    model: Subscription<PointCloud2>,
    detections: Subscription<Detection3DArray>,
    path: Subscription<Path>,
    next_view: Subscription<PoseStamped>,
    diagnostics: Subscription<DiagnosticArray>,
    transforms: Subscription<TFMessage>,
}

pub fn listen(node: &mut Node, name: &str, span: Duration) {
    let live = QosProfile::subscription_default().history_last(20).reliable();
    let latched = live.clone().durability(Durability::TransientLocal);
    let below = |topic: &str| format!("/{name}/{topic}");
    let subscriptions = Subscriptions {
        model: subscribed(node, &below("model"), PointCloud2::kind(), &latched),
        detections: subscribed(node, &below("detections"), Detection3DArray::kind(), &latched),
        path: subscribed(node, &below("path"), Path::kind(), &latched),
        next_view: subscribed(node, &below("next_view"), PoseStamped::kind(), &latched),
        diagnostics: subscribed(node, "/diagnostics", DiagnosticArray::kind(), &live),
        transforms: subscribed(node, "/tf", TFMessage::kind(), &live),
    };
    println!("{{\"topic\": \"ready\"}}");
    let start = Instant::now();
    while start.elapsed() < span {
        if !subscriptions.print_all() {
            sleep(Duration::from_millis(5));
        }
    }
}

fn subscribed<M: Message + 'static>(
    node: &mut Node,
    topic: &str,
    kind: MessageTypeName,
    qos: &QosProfile,
) -> Subscription<M> {
    subscription(node, topic, kind, qos)
}

/// The next message; an unreadable one is printed as such.
fn next<M: Message + 'static>(topic: &str, from: &Subscription<M>) -> Option<M> {
    match from.take() {
        Ok(taken) => taken.map(|(message, _)| message),
        Err(error) => {
            println!("{{\"topic\": \"unreadable\", \"of\": {topic:?}, \"why\": {:?}}}", format!("{error:?}"));
            None
        }
    }
}

impl Subscriptions {
    fn print_all(&self) -> bool {
        let mut any = false;
        if let Some(message) = next("model", &self.model) {
            any = true;
            println!("{}", model(&message));
        }
        if let Some(message) = next("detections", &self.detections) {
            any = true;
            println!("{}", detections(&message));
        }
        if let Some(message) = next("path", &self.path) {
            any = true;
            let last = message.poses.last().map(|stamped| place(&stamped.pose));
            println!(
                "{{\"topic\": \"path\", \"frame\": {:?}, \"poses\": {}, \"last\": {}}}",
                message.header.frame_id,
                message.poses.len(),
                last.unwrap_or("null".into()),
            );
        }
        if let Some(message) = next("next_view", &self.next_view) {
            any = true;
            let frame = &message.header.frame_id;
            println!(
                "{{\"topic\": \"next_view\", \"frame\": {frame:?}, \"place\": {}}}",
                place(&message.pose)
            );
        }
        if let Some(message) = next("diagnostics", &self.diagnostics) {
            any = true;
            for status in &message.status {
                println!("{}", diagnosis(status));
            }
        }
        if let Some(message) = next("tf", &self.transforms) {
            any = true;
            for stamped in &message.transforms {
                println!(
                    "{{\"topic\": \"tf\", \"parent\": {:?}, \"child\": {:?}}}",
                    stamped.header.frame_id, stamped.child_frame_id
                );
            }
        }
        any
    }
}

fn model(message: &PointCloud2) -> String {
    let names: Vec<&str> = message.fields.iter().map(|field| field.name.as_str()).collect();
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for point in message.data.chunks_exact(message.point_step as usize) {
        for axis in 0..3 {
            let at = message.fields[axis].offset as usize;
            let value = f32::from_le_bytes(point[at..at + 4].try_into().unwrap());
            low[axis] = low[axis].min(value);
            high[axis] = high[axis].max(value);
        }
    }
    let (low, high) = if message.width == 0 { ([0.0; 3], [0.0; 3]) } else { (low, high) };
    format!(
        "{{\"topic\": \"model\", \"frame\": {:?}, \"points\": {}, \"fields\": {names:?}, \"low\": \
         {low:?}, \"high\": {high:?}}}",
        message.header.frame_id, message.width
    )
}

fn detections(message: &Detection3DArray) -> String {
    let mut best = String::from("null");
    if let Some(result) = message.detections.first().and_then(|one| one.results.first()) {
        best = format!("{:?}", result.hypothesis.class_id);
    }
    let score = message.detections.first().and_then(|one| one.results.first());
    let stamp = &message.header.stamp;
    format!(
        "{{\"topic\": \"detections\", \"frame\": {:?}, \"count\": {}, \"label\": {best}, \
         \"score\": {}, \"stamp\": {}.{:09}}}",
        message.header.frame_id,
        message.detections.len(),
        score.map_or(0.0, |result| result.hypothesis.score),
        stamp.sec,
        stamp.nanosec,
    )
}

fn diagnosis(status: &DiagnosticStatus) -> String {
    let pairs: Vec<String> =
        status.values.iter().map(|pair| format!("{:?}: {:?}", pair.key, pair.value)).collect();
    format!(
        "{{\"topic\": \"diagnostics\", \"level\": {}, \"name\": {:?}, \"message\": {:?}, \
         \"values\": {{{}}}}}",
        status.level,
        status.name,
        status.message,
        pairs.join(", ")
    )
}

fn place(pose: &Pose) -> String {
    let Vector3 { x, y, z } = pose.position;
    format!("[{x}, {y}, {z}]")
}

/// Prints every node and topic that is discovered within a time.
pub fn print_topics(node: &mut Node, context: &ros2_client::Context, span: Duration) {
    let spinner = node.spinner().unwrap();
    let events = node.status_receiver().unwrap();
    std::thread::spawn(move || futures::executor::block_on(spinner.spin()));
    let start = Instant::now();
    while start.elapsed() < span {
        while let Ok(event) = events.try_recv() {
            if let NodeEvent::ParticipantEntities(info) = event {
                for found in info.nodes() {
                    println!("{{\"node\": {:?}}}", found.fully_qualified_name());
                }
            }
        }
        sleep(Duration::from_millis(20));
    }
    for topic in context.domain_participant().discovered_topics() {
        let name = topic.topic_name();
        println!("{{\"topic\": {name:?}, \"type\": {:?}}}", topic.type_name());
    }
}

trait Shorter {
    fn history_last(self, depth: usize) -> Self;
    fn reliable(self) -> Self;
}

impl Shorter for QosProfile {
    fn history_last(self, depth: usize) -> Self {
        self.history(ros2_client::qos::History::KeepLast { depth })
    }

    fn reliable(self) -> Self {
        self.reliability_reliable(ros2_client::qos::WhenFull::DEFAULT)
    }
}
