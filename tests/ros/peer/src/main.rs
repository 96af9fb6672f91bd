//! An independent ROS 2 peer for circumspect's tests: RustDDS shares no code with Cyclone DDS.
//!
//! ros2-peer DOMAIN talk SCENE RATE best-effort|reliable ROUNDS
//! ros2-peer DOMAIN listen NODE SECONDS
//! ros2-peer DOMAIN command TOPIC...
//! ros2-peer DOMAIN topics SECONDS

mod listen;
mod messages;
mod node;
mod scene;
mod talk;

use std::env;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(60);

fn main() {
    let words: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let context = node::context(words[0].parse().expect("a domain"));
    let mut node = node::node(&context);
    match words[1..] {
        ["talk", scene, rate, reliability, rounds] => {
            let settings = talk::PublishSettings {
                rate: rate.parse().expect("a rate"),
                reliable: reliability == "reliable",
                rounds: rounds.parse().expect("a count"),
                patience: PATIENCE,
            };
            talk::talk(&mut node, &scene::Scene::read(scene).expect("a scene"), &settings);
            // The last samples must arrive before the process ends.
            std::thread::sleep(Duration::from_millis(500));
        }
        ["listen", name, seconds] => listen::listen(&mut node, name, seconds_of(seconds)),
        ["command", ref topics @ ..] => {
            for topic in topics {
                talk::command(&mut node, topic, PATIENCE);
            }
        }
        ["topics", seconds] => listen::print_topics(&mut node, &context, seconds_of(seconds)),
        _ => panic!("talk, listen, command or topics"),
    }
}

fn seconds_of(word: &str) -> Duration {
    Duration::from_secs_f64(word.parse().expect("seconds"))
}
