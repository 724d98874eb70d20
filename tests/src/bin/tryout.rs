//! Experiment: picture errors.
#![allow(missing_docs)]
use fogbank_core::airlight::reference;
use fogbank_core::geometry::Geometry;
use fogbank_core::media::Field;
use fogbank_core::request::{Layer, Quality, Tonemap, View};

use fogbank_core::scene::{Projection, Scene};
use fogbank_core::{Progress, Renderer};
use fogbank_tests::{scenes::Random, trials};
use glam::DVec3;
use serde_json::from_value;

fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<_> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) * 10.0
}

fn main() {
    let only = std::env::args().nth(1);
    let draft = std::env::args().nth(2).is_some();
    let mut all = trials::exact();
    all.extend(trials::hard());
    let renderer = Renderer::default();
    for t in all {
        if only.as_ref().is_some_and(|o| !t.name.contains(o.as_str())) {
            continue;
        }
        let scene: Scene = from_value(t.scene.clone()).unwrap();
        let scene = scene.check().unwrap();
        let field = Field::new(&scene.fog);
        let geo = Geometry::build(&scene.surfaces);
        let cam = &scene.camera;
        let eye: DVec3 = DVec3::from_array(cam.position.0);
        let fwd = (DVec3::from_array(cam.target.0) - eye).normalize();
        let right = fwd.cross(DVec3::from_array(cam.up.0)).normalize();
        let up = right.cross(fwd);
        let half = match &cam.projection {
            Projection::Perspective(p) => (0.5 * p.vertical_fov_deg.to_radians()).tan(),
            _ => 1.0,
        };
        let ray = |(i, j): (usize, usize)| {
            let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
            (fwd + right * half * (800.0 / 600.0) * (2.0 * x / 800.0 - 1.0)
                - up * half * (2.0 * y / 600.0 - 1.0))
                .normalize()
        };
        let view = View {
            width: 800,
            height: 600,
            quality: if draft { Quality::Draft } else { Quality::Full },
            layer: Layer::Airlight,
            samples: Some(1),
            exposure_ev: 0.0,
            tonemap: Tonemap::None,
            for_screen: false,
            estimator: None,
        };
        let mut ms = f64::INFINITY;
        let mut frame = None;
        for _ in 0..3 {
            let t0 = cpu();
            let f = renderer.render(&scene, &view, &Progress::default()).unwrap();
            ms = ms.min(cpu() - t0);
            frame = Some(f);
        }
        let frame = frame.unwrap();
        let mut line = format!("{:12} {ms:7.1} ms", t.name);
        let laps: Vec<_> = frame
            .timings
            .iter()
            .filter(|(n, _)| ["airlight", "low_resolution"].contains(n))
            .map(|(n, d)| format!("{}{:.0}", &n[..1], d.as_secs_f64() * 1e3))
            .collect();
        line += &format!(" [{}]", laps.join(" "));

        if std::env::var("FAST").is_ok() {
            println!("{line}");
            continue;
        }
        let mut rnd = Random(5);
        let mut main = vec![];
        for _ in 0..108 {
            main.push((rnd.between(0.0, 800.0) as usize, rnd.between(0.0, 600.0) as usize));
        }
        let mut sets = vec![("main", main)];
        let mut halo = vec![];
        for (_, l) in scene.lights() {
            let p = DVec3::from_array(l.position.vector().to_array()) - eye;
            let depth = p.dot(fwd);
            if depth <= 0.0 {
                continue;
            }
            let x = (p.dot(right) / depth / half / (800.0 / 600.0) + 1.0) * 400.0;
            let y = (1.0 - p.dot(up) / depth / half) * 300.0;
            for _ in 0..40 {
                let r = rnd.decades(0.5, 60.0);
                let a = rnd.between(0.0, 6.2831853);
                let (x, y) = (x + r * a.cos(), y + r * a.sin());
                if x > 0.0 && x < 800.0 && y > 0.0 && y < 600.0 {
                    halo.push((x as usize, y as usize));
                }
            }
        }
        sets.push(("halo", halo));
        for (name, rays) in sets {
            let mut e = vec![];
            for px in &rays {
                let d = ray(*px);
                let len = geo.first_hit(eye, d, scene.far_m).map_or(scene.far_m, |h| h.distance);
                let mut b = 0.0;
                for (_, l) in scene.lights() {
                    let p = l.position.vector();
                    b += l.intensity.0[1]
                        * scene.fog.albedo.0[1]
                        * reference::airlight(
                            &field,
                            fogbank_core::phase::Phase::from(&scene.fog.phase),
                            p,
                            eye,
                            d,
                            len,
                        );
                }
                let a = f64::from(frame.pixels[(px.1 * 800 + px.0) * 3 + 1]);
                e.push((0.0, *px, a, b));
            }
            if e.is_empty() {
                continue;
            }
            let floor = 1e-3 * e.iter().map(|e| e.3).sum::<f64>() / e.len() as f64;
            for x in &mut e {
                x.0 = (x.2 - x.3).abs() / x.3.max(floor);
            }
            e.sort_by(|a, b| a.0.total_cmp(&b.0));
            let q = |p: f64| e[((e.len() - 1) as f64 * p) as usize].0 * 100.0;
            line += &format!(" {name} {:8.4} {:8.3} {:8.2} |", q(0.5), q(0.95), q(1.0));
            if only.is_some() {
                for x in &e[e.len().saturating_sub(4)..] {
                    line += &format!("\n    {:?}", x);
                }
            }
        }
        println!("{line}");
    }
}
