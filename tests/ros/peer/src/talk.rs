//! Publishes depth images, CameraInfo, odometry and the mount of the camera, as a robot does.

use std::thread::sleep;
use std::time::{Duration, Instant};

use ros2_client::{qos::Durability, Node, Publisher, QosProfile};

use crate::messages::*;
use crate::node::{publisher, publisher_qos};
use crate::scene::{Frame, Scene};

const DEPTH: &str = "/camera/depth/image_rect_raw";
const OPTICAL: &str = "camera_depth_optical_frame";

/// How frames are published.
pub struct PublishSettings {
    pub rate: f64,
    pub reliable: bool,
    /// How often the scene is published; the stamps increase throughout.
    pub rounds: usize,
    pub patience: Duration,
}

struct Robot {
    depth: Publisher<Image>,
    info: Publisher<CameraInfo>,
    odometry: Publisher<Odometry>,
    mount: Publisher<TFMessage>,
}

pub fn talk(node: &mut Node, scene: &Scene, settings: &PublishSettings) {
    let sensor = publisher_qos(settings.reliable, 30);
    let fixed = publisher_qos(true, 1).durability(Durability::TransientLocal);
    let robot = Robot {
        depth: publisher(node, DEPTH, Image::kind(), &sensor),
        info: publisher(node, "/camera/depth/camera_info", CameraInfo::kind(), &sensor),
        odometry: publisher(node, "/odom", Odometry::kind(), &sensor),
        mount: publisher(node, "/tf_static", TFMessage::kind(), &fixed),
    };
    robot.mount.publish(mounted(scene)).unwrap();
    wait_for_reader(node, settings.patience);
    let span = settings.rounds as f64 * scene.frames.len() as f64;
    let images: Vec<Image> = scene.frames.iter().map(|frame| image(scene, frame)).collect();
    let start = Instant::now();
    for count in 0..span as usize {
        let at = count % scene.frames.len();
        let due = start + Duration::from_secs_f64(count as f64 / settings.rate);
        sleep(due.saturating_duration_since(Instant::now()));
        let round = (count / scene.frames.len()) as f64;
        let length = scene.frames.len() as f64 / settings.rate;
        publish_frame(&robot, scene, &scene.frames[at], &images[at], round * length);
    }
    let spent = start.elapsed().as_secs_f64();
    println!("{{\"topic\": \"end\", \"sent\": {}, \"seconds\": {spent:.3}}}", span as usize);
    // Readers request lost samples after a heartbeat; until then this writer must stay alive.
    std::io::stdin().read_line(&mut String::new()).unwrap();
}

fn wait_for_reader(node: &Node, patience: Duration) {
    let start = Instant::now();
    while node.subscription_count(DEPTH) == 0 {
        assert!(start.elapsed() < patience, "nobody reads {DEPTH}");
        sleep(Duration::from_millis(20));
    }
    // Discovery must finish on both sides and on every topic. The caller checks that and sends a line.
    sleep(Duration::from_millis(500));
    println!("{{\"topic\": \"ready\"}}");
    std::io::stdin().read_line(&mut String::new()).unwrap();
}

fn publish_frame(robot: &Robot, scene: &Scene, frame: &Frame, image: &Image, later: f64) {
    let stamp = frame.stamp + later;
    let odometry = Odometry {
        header: header(stamp, "odom"),
        child_frame_id: "base_link".into(),
        pose: PoseWithCovariance { pose: frame.place.clone(), ..Default::default() },
        ..Default::default()
    };
    robot.odometry.publish(odometry).unwrap();
    robot.info.publish(info(scene, stamp)).unwrap();
    let mut image = image.clone();
    image.header = header(stamp, OPTICAL);
    robot.depth.publish(image).unwrap();
}

fn image(scene: &Scene, frame: &Frame) -> Image {
    Image {
        height: scene.height,
        width: scene.width,
        encoding: if scene.bits == 16 { "16UC1" } else { "32FC1" }.into(),
        step: scene.width * scene.bits / 8,
        data: frame.pixels.clone(),
        ..Default::default()
    }
}

fn info(scene: &Scene, stamp: f64) -> CameraInfo {
    let [fx, fy, cx, cy] = scene.intrinsics;
    CameraInfo {
        header: header(stamp, OPTICAL),
        height: scene.height,
        width: scene.width,
        distortion_model: "plumb_bob".into(),
        d: vec![0.0; 5],
        k: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..Default::default()
    }
}

fn mounted(scene: &Scene) -> TFMessage {
    let transform = Transform {
        translation: scene.mount.position.clone(),
        rotation: scene.mount.orientation.clone(),
    };
    let header = header(0.0, "base_link");
    TFMessage {
        transforms: vec![TransformStamped { header, child_frame_id: OPTICAL.into(), transform }],
    }
}

fn header(stamp: f64, frame: &str) -> Header {
    let whole = (stamp * 1e9).round() as i64;
    let stamp = Time {
        sec: (whole / 1_000_000_000) as i32,
        nanosec: (whole % 1_000_000_000) as u32,
    };
    Header { stamp, frame_id: frame.into() }
}

/// Publishes one Empty, as `ros2 topic pub --once` would.
pub fn command(node: &mut Node, topic: &str, patience: Duration) {
    let qos: QosProfile = publisher_qos(true, 10);
    let publisher = publisher::<Empty>(node, topic, Empty::kind(), &qos);
    let start = Instant::now();
    while node.subscription_count(topic) == 0 {
        assert!(start.elapsed() < patience, "nobody reads {topic}");
        sleep(Duration::from_millis(20));
    }
    sleep(Duration::from_millis(300));
    publisher.publish(Empty::default()).unwrap();
    sleep(Duration::from_millis(300));
    println!("{{\"sent\": 1}}");
}
