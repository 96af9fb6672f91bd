//! Frames of a robot, read from the file that the tests write.
//!
//! All of it is little endian: width, height, frames (u32), 16 or 32 bits a pixel (u32); fx, fy,
//! cx, cy; the camera's mount x y z qx qy qz qw (f64). Of each frame: stamp, place
//! x y z qx qy qz qw (f64), pixels.

use std::{fs, io};

use crate::messages::{Pose, Quaternion, Vector3};

pub struct Frame {
    pub stamp: f64,
    pub place: Pose,
    pub pixels: Vec<u8>,
}

pub struct Scene {
    pub width: u32,
    pub height: u32,
    pub bits: u32,
    pub intrinsics: [f64; 4],
    pub mount: Pose,
    pub frames: Vec<Frame>,
}

struct Bytes {
    held: Vec<u8>,
    at: usize,
}

impl Bytes {
    fn take(&mut self, count: usize) -> &[u8] {
        self.at += count;
        &self.held[self.at - count..self.at]
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4).try_into().unwrap())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take(8).try_into().unwrap())
    }

    fn pose(&mut self) -> Pose {
        let [x, y, z] = std::array::from_fn(|_| self.f64());
        let position = Vector3 { x, y, z };
        let [x, y, z, w] = std::array::from_fn(|_| self.f64());
        Pose { position, orientation: Quaternion { x, y, z, w } }
    }
}

impl Scene {
    pub fn read(path: &str) -> io::Result<Scene> {
        let mut bytes = Bytes { held: fs::read(path)?, at: 0 };
        let [width, height, count, bits] = std::array::from_fn(|_| bytes.u32());
        let intrinsics = std::array::from_fn(|_| bytes.f64());
        let mount = bytes.pose();
        let size = (width * height * bits / 8) as usize;
        let frames = (0..count)
            .map(|_| Frame {
                stamp: bytes.f64(),
                place: bytes.pose(),
                pixels: bytes.take(size).to_vec(),
            })
            .collect();
        Ok(Scene { width, height, bits, intrinsics, mount, frames })
    }
}
