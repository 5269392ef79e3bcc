use std::io::Write;
use throng_precompute::annotate::*;
use throng_precompute::import::*;
use throng_precompute::resample::*;
use throng_precompute::retarget::*;
use throng_precompute::*;
use throng_runtime::*;
fn main() {
    let mut args = std::env::args().skip(1);
    let mode = args.next().unwrap();
    let paths: Vec<std::path::PathBuf> = args.map(Into::into).collect();
    let t = std::time::Instant::now();
    let set = read(&paths, &ImportConfig::default(), &progress::Silent).unwrap();
    eprintln!("import {:?} skipped {}", t.elapsed(), set.skipped.len());
    match mode.as_str() {
        "own" => {
            for i in &set.clips {
                let sk = skeleton_of(i).unwrap();
                let cfg = RetargetConfig { proportions: Proportions::Clip, align_ground: false };
                let c = onto(std::slice::from_ref(i), &cfg, &mut Warnings::default()).unwrap();
                assert_eq!(c.skeleton, sk);
                let mut worst = [0.0f32; 22];
                for f in 0..i.clip.num_frames {
                    let w = i.clip.world(f);
                    let p = c.clips[0].joint_positions(&sk, f);
                    for j in Joint::ALL {
                        if let Some(s) = i.roles.get(j) {
                            worst[j.index()] = worst[j.index()].max((w[s].0 - p[j.index()]).length());
                        }
                    }
                }
                let m = worst.iter().copied().fold(0.0, f32::max);
                println!("{} kind {:?} worst {:.2e}", i.clip.name, i.rest_pose.kind, m);
                if m > 1e-4 {
                    for j in Joint::ALL {
                        if worst[j.index()] > 1e-4 {
                            print!("  {} {:.2e}", j.name(), worst[j.index()]);
                        }
                    }
                    println!();
                }
                if m < 1e-4 || i.clip.name.contains("walk_normal_001") {
                    for j in Joint::ALL {
                        let o = sk.offsets[j.index()];
                        print!("{}:({:.3},{:.3},{:.3}) ", j.name(), o.x, o.y, o.z);
                    }
                    println!("\n tips {:?} leg {:.3}", sk.tips, sk.leg_length());
                }
            }
        }
        "dump" | "table" => {
            let t = std::time::Instant::now();
            let c = onto(&set.clips, &RetargetConfig::default(), &mut Warnings::default()).unwrap();
            eprintln!("retarget {:?}", t.elapsed());
            let t = std::time::Instant::now();
            let r = resample(&c, &ResampleConfig { rate_hz: 30.0, mirror: false });
            eprintln!("resample {:?}", t.elapsed());
            let t = std::time::Instant::now();
            let a = annotate(&r, &AnnotateConfig::default(), &Sidecars::default()).unwrap();
            eprintln!("annotate {:?}", t.elapsed());
            for (k, clip) in a.clips.iter().enumerate() {
                let s = sanity(clip, &a.skeleton);
                let ex: Vec<String> = clip
                    .excluded
                    .iter()
                    .map(|e| format!("{:?} {}..{}", e.reason, e.range.start, e.range.end))
                    .collect();
                println!(
                    "{:32} n {:5} L {:.2} R {:.2} mean {:.3} p95 {:.3}  {}",
                    clip.name,
                    clip.num_frames(),
                    s.left_share,
                    s.right_share,
                    s.mean_speed_mps,
                    s.p95_speed_mps,
                    ex.join(", ")
                );
                if mode == "dump" {
                    let i = &set.clips[k];
                    let mut o = std::io::BufWriter::new(
                        std::fs::File::create(format!("/tmp/rt/{}.json", clip.name.replace('/', "_"))).unwrap(),
                    );
                    write!(o, "{{\"frames\":[").unwrap();
                    for f in 0..clip.num_frames() {
                        let src = ((f as f64 * i.clip.rate_hz / 30.0).round() as usize).min(i.clip.num_frames - 1);
                        let w = i.clip.world(src);
                        let tr = clip.joint_transforms(&a.skeleton, f);
                        if f > 0 {
                            write!(o, ",").unwrap();
                        }
                        write!(o, "{{\"c\":{},\"u\":{},\"p\":[", clip.contacts[f].0, clip.is_usable(f)).unwrap();
                        for (k, (p, q)) in tr.iter().enumerate() {
                            write!(
                                o,
                                "{}[{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4}]",
                                if k > 0 { "," } else { "" },
                                p.x,
                                p.y,
                                p.z,
                                q.x,
                                q.y,
                                q.z,
                                q.w
                            )
                            .unwrap();
                        }
                        write!(o, "],\"s\":[").unwrap();
                        for (k, (p, _)) in w.iter().enumerate() {
                            write!(o, "{}[{:.4},{:.4},{:.4}]", if k > 0 { "," } else { "" }, p.x, p.y, p.z).unwrap();
                        }
                        write!(o, "]}}").unwrap();
                    }
                    write!(o, "],\"parents\":[").unwrap();
                    for (k, j) in i.clip.joints.iter().enumerate() {
                        write!(o, "{}{}", if k > 0 { "," } else { "" }, j.parent.map_or(-1, |p| p as i32)).unwrap();
                    }
                    write!(o, "]}}").unwrap();
                }
            }
        }
        _ => {}
    }
}
