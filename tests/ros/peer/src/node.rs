//! A node on this machine alone.

use std::net::Ipv4Addr;

use ros2_client::qos::{History, WhenFull};
use ros2_client::{
    Context, Message, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile,
    Subscription,
};
use rustdds::DomainParticipantBuilder;

pub fn context(domain: u16) -> Context {
    let participant = DomainParticipantBuilder::new(domain)
        .with_only_networks([Ipv4Addr::LOCALHOST])
        .build()
        .unwrap();
    Context::from_domain_participant(participant).unwrap()
}

pub fn node(context: &Context) -> Node {
    let name = NodeName::new("/", "peer").unwrap();
    let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
    context.new_node(name, options).unwrap()
}

pub fn publisher_qos(reliable: bool, depth: usize) -> QosProfile {
    let qos = QosProfile::publisher_default().history(History::KeepLast { depth });
    if reliable {
        qos.reliability_reliable(WhenFull::DEFAULT)
    } else {
        qos.reliability_best_effort()
    }
}

pub fn publisher<M: Message>(
    node: &mut Node,
    topic: &str,
    kind: MessageTypeName,
    qos: &QosProfile,
) -> Publisher<M> {
    let topic = node.create_topic(&Name::parse(topic).unwrap(), kind, qos).unwrap();
    node.create_publisher(&topic, None).unwrap()
}

pub fn subscription<M: Message + 'static>(
    node: &mut Node,
    topic: &str,
    kind: MessageTypeName,
    qos: &QosProfile,
) -> Subscription<M> {
    let topic = node.create_topic(&Name::parse(topic).unwrap(), kind, qos).unwrap();
    node.create_subscription(&topic, None).unwrap()
}
