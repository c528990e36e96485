// SPDX-License-Identifier: Apache-2.0
//! Times OpenDefocus on one frame.
//!
//!     opendefocus-bench VERSION QUALITY IN OUT RUNS
//!
//! VERSION is 0.1 (qualities low, medium, high) or 0.2 (fast, accurate). IN holds, little
//! endian: int32 width and height, float largest radius in px, then RGBA floats of all
//! pixels, then their signed radius in px, positive behind the focus. OUT receives the
//! RGBA floats. Prints one line per run: wall seconds and CPU seconds of the rendering.
//! Threads: RAYON_NUM_THREADS for 0.1, LP_NUM_THREADS for 0.2 on lavapipe.

use futures::executor::block_on;
use std::time::Instant;

struct Frame {
    width: usize,
    height: usize,
    max_radius: f32,
    colour: Vec<f32>,
    /// Positive before the focus, as OpenDefocus has it.
    radius: Vec<f32>,
}

fn read_frame(path: &str) -> Frame {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let word = |i: usize| <[u8; 4]>::try_from(&bytes[4 * i..4 * i + 4]).unwrap();
    let width = i32::from_le_bytes(word(0)) as usize;
    let height = i32::from_le_bytes(word(1)) as usize;
    let float = |i: usize| f32::from_le_bytes(word(i));
    let n = width * height;
    Frame {
        width,
        height,
        max_radius: float(2),
        colour: (3..3 + 4 * n).map(float).collect(),
        radius: (3 + 4 * n..3 + 5 * n).map(|i| -float(i)).collect(),
    }
}

fn cpu_seconds() -> f64 {
    let mut usage = unsafe { std::mem::zeroed::<libc::rusage>() };
    unsafe { libc::getrusage(libc::RUSAGE_SELF, &mut usage) };
    let seconds = |t: libc::timeval| t.tv_sec as f64 + t.tv_usec as f64 * 1e-6;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

/// The two versions differ in names only.
macro_rules! run {
    ($opendefocus:ident, $ndarray:ident, $frame:expr, $quality:expr, $n_runs:expr,
     $new:expr) => {{
        use $opendefocus::datamodel::{defocus::DefocusMode, Settings};
        let shape = ($frame.height, $frame.width, 4);
        let colour = $ndarray::Array3::from_shape_vec(shape, $frame.colour).unwrap();
        let radius =
            $ndarray::Array2::from_shape_vec((shape.0, shape.1), $frame.radius).unwrap();
        let mut settings = Settings::default();
        settings.defocus.set_defocus_mode(DefocusMode::Depth);
        settings.defocus.use_direct_math = true; // depth is the signed radius
        settings.defocus.circle_of_confusion.max_size = $frame.max_radius;
        settings.defocus.camera_max_size = $frame.max_radius;
        settings.render.set_quality($quality);
        settings.render.set_farm_quality($quality);
        let renderer = block_on($new(&mut settings)).unwrap();
        eprintln!("{}", settings.render.device_name.clone().unwrap_or_default());
        let mut out = colour.clone();
        for _ in 0..$n_runs {
            out.assign(&colour);
            let (settings, depth) = (settings.clone(), Some(radius.clone()));
            let (wall, cpu) = (Instant::now(), cpu_seconds());
            block_on(renderer.render(settings, out.view_mut(), depth, None)).unwrap();
            let cpu = cpu_seconds() - cpu;
            println!("{:.4} {:.4}", wall.elapsed().as_secs_f64(), cpu);
        }
        out.into_raw_vec_and_offset().0
    }};
}

fn run_01(frame: Frame, quality: &str, n_runs: usize) -> Vec<f32> {
    use opendefocus01::{datamodel::render::Quality, OpenDefocusRenderer};
    let quality = match quality {
        "low" => Quality::Low,
        "medium" => Quality::Medium,
        "high" => Quality::High,
        _ => panic!("0.1 has the qualities low, medium and high"),
    };
    run!(opendefocus01, ndarray01, frame, quality, n_runs, |s| {
        OpenDefocusRenderer::new(false, s)
    })
}

fn run_02(frame: Frame, quality: &str, n_runs: usize) -> Vec<f32> {
    use opendefocus02::{datamodel::render::Quality, OpenDefocusRenderer};
    let quality = match quality {
        "fast" => Quality::Fast,
        "accurate" => Quality::Accurate,
        _ => panic!("0.2 has the qualities fast and accurate"),
    };
    run!(opendefocus02, ndarray02, frame, quality, n_runs, |s| {
        OpenDefocusRenderer::new(s)
    })
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let [_, version, quality, from, to, n_runs] = &args[..] else {
        panic!("usage: opendefocus-bench VERSION QUALITY IN OUT RUNS");
    };
    let frame = read_frame(from);
    let n_runs = n_runs.parse().expect("RUNS is a number");
    let out = match version.as_str() {
        "0.1" => run_01(frame, quality, n_runs),
        "0.2" => run_02(frame, quality, n_runs),
        _ => panic!("VERSION is 0.1 or 0.2"),
    };
    let bytes: Vec<u8> = out.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(to, bytes).unwrap_or_else(|e| panic!("{to}: {e}"));
}
