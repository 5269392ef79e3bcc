//! probe
use throng_precompute::import::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let c = read_clip(a[1].as_ref(), &ImportConfig::default()).unwrap();
    print!("{}", inspect::ClipReport::new(&c));
    export::positions_csv(&c.clip, &mut std::io::BufWriter::new(std::fs::File::create(&a[2]).unwrap())).unwrap();
    bvh_write::write(&c.clip, &mut std::io::BufWriter::new(std::fs::File::create(a[2].replace(".csv", ".bvh")).unwrap())).unwrap();
}
