use throng_precompute::{import::*, progress::Silent};
use throng_runtime::Joint;
fn main() {
    let args: Vec<std::path::PathBuf> = std::env::args().skip(1).map(Into::into).collect();
    let t = std::time::Instant::now();
    let set = read(&args, &ImportConfig::default(), &Silent).unwrap();
    println!("{} clips {} skipped {:?}", set.clips.len(), set.skipped.len(), t.elapsed());
    for e in &set.skipped {
        println!("SKIP {e}");
    }
    for c in &set.clips {
        let n = c.clip.num_frames;
        let y = (0..n)
            .map(|f| {
                let w = c.clip.world(f);
                [Joint::LeftFoot, Joint::RightFoot, Joint::LeftToe, Joint::RightToe]
                    .iter()
                    .map(|j| w[c.roles.get(*j).unwrap()].0.y)
                    .fold(9.0, f32::min)
            })
            .collect::<Vec<_>>();
        let mut s = y.clone();
        s.sort_by(f32::total_cmp);
        println!(
            "{} {}f {}Hz h={:.2} u={:.5} {:?} {:?} facing {:.0} prof={} roles={} ymin={:.3} y50={:.3} w={:?}",
            c.clip.name,
            n,
            c.clip.rate_hz,
            c.height,
            c.metres_per_unit,
            c.up,
            c.rest_pose.kind,
            c.facing.to_degrees(),
            c.roles.profile,
            c.roles.joints.iter().flatten().count(),
            s[0],
            s[n / 2],
            c.warnings.messages
        );
    }
    let c = &set.clips[0];
    for f in &c.findings {
        println!("  {f}");
    }
    if c.rest_pose.kind == RestPoseKind::Other {
        for r in Joint::ALL {
            if let Some(j) = c.roles.get(r) {
                let m = glam::Mat3::from_quat(c.rest_pose.reference[j]);
                println!("{:16} x->{:.2} y->{:.2} z->{:.2}", r.name(), m.x_axis, m.y_axis, m.z_axis);
            }
        }
    }
}
