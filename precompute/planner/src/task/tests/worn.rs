//! Meshes that characters wear.

use super::*;
use throng_core::Joint;

#[test]
fn what_somebody_wears_is_in_the_way() {
    let folder = tempfile::tempdir().expect("a folder");
    let s = TestCharacter::standing();
    let file = crate::stiff_mesh::tests::figure_file(folder.path(), &s.skeleton);
    let body = |more: &str| {
        let text = format!(
            "clip = \"stand.bvh\"\n{more}\n[[characters]]\nname = \"Bo\"\nclip = \"b.bvh\"\nat = [0.25, 0.0, 0.7]\nheading_deg = 180.0\nBODY\n\
             [[scene.objects]]\nname = \"cup\"\nshape = {{ ball = {{ radius = 0.03 }} }}\nat = [0.25, 1.3, 0.42]\n\
             [[tasks]]\nlimb = \"left_arm\"\ndo = \"touch\"\nobject = \"cup\"\ngrips = [{{ at = [0.0, 0.0, -0.06] }}]\nat_s = 1.4\nwindow_s = [0.4, 2.4]\n"
        );
        text
    };
    let with = |text: String| {
        let task = Task::parse(&text, &folder.path().join("t.toml")).map_err(|e| e.to_string())?;
        let clips = vec![ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }; 2];
        Ok::<_, String>(task.run(&clips, None).expect("clips"))
    };
    let name = file.file_name().expect("a name").to_string_lossy().into_owned();
    let plain = with(body("").replace("BODY", "")).expect("a task");
    let worn = with(body("").replace("BODY", &format!("body = \"{name}\""))).expect("a task");
    for outcome in [&plain, &worn] {
        assert!(outcome.is_solved(), "{}", why(outcome, 0));
        assert_eq!(outcome.recheck.violations, []);
    }
    // A step nearer, the cup is in what Bo wears.
    let nearer =
        with(body("").replace("BODY", &format!("body = \"{name}\"")).replace("0.7]", "0.46]")).expect("a task");
    assert!(why(&nearer, 0).contains("blocked by Bo"), "{}", why(&nearer, 0));
    // In the stage, the mesh is where the joints are.
    let text = body(&format!("body = \"{name}\"")).replace("BODY", &format!("body = \"{name}\""));
    let task = Task::parse(&text, &folder.path().join("t.toml")).expect("a task");
    let clips = vec![ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }; 2];
    let stage = crate::task::stage::TaskStage::new(&task, &clips);
    let around = stage.surroundings_of_limb(0, crate::linkage::Limb::LeftArm, [0.4, 1.4]);
    let pieces: Vec<_> = around.solids.iter().filter(|solid| solid.name == "Bo").collect();
    assert!(pieces.len() > 15 && stage.other_bodies(0).is_empty() && stage.other_capsules(0, |_| true).len() == 1);
    let head = stage.actors[1].joint_place(Joint::Head, 1.0).position;
    let nearest = |at: glam::DVec3| {
        let far = |solid: &&crate::problem::MovingSolid| {
            let p = solid.path.place_at(1.0).local_point(at);
            solid.shape.distance(&throng_geometry::Segment::new(p, p), 9.0)
        };
        pieces.iter().map(far).fold(9.0, f64::min)
    };
    assert!(nearest(head) < 0.2 && nearest(head + glam::DVec3::Y * 0.5) > 0.15, "{}", nearest(head));
    // The own arm is as thick as what it wears, not as people are.
    let radius = |stage: &crate::task::stage::TaskStage<'_>| {
        stage.actors[0].shape.capsules.iter().find(|c| c.joint == Joint::LeftForearm).map(|c| c.radius)
    };
    let bare = Task::parse(&body("").replace("BODY", ""), &folder.path().join("t.toml")).expect("a task");
    assert_ne!(radius(&stage), radius(&crate::task::stage::TaskStage::new(&bare, &clips)));
    let missing = with(body("").replace("BODY", "body = \"nobody.glb\"")).unwrap_err();
    assert!(missing.contains("nobody.glb") && missing.contains("t.toml:"), "{missing}");
}
