//! Skeletons of many tools are recognised without a profile, and what is no person is refused with the reason.

mod captured;
mod refused;
pub mod rig;
pub mod tables;

use rig::{Rest, RigPart, Style, bvh, parse};
use std::f32::consts::{FRAC_PI_2, PI};
use std::path::Path;
use throng_core::Joint;
use throng_motion::ImportError;
use throng_motion::import::{ImportConfig, ImportedClip, bvh as reader, interpret};

fn import(parts: &[RigPart], style: &Style) -> Result<ImportedClip, ImportError> {
    import_with(parts, style, &ImportConfig::default())
}

fn import_with(parts: &[RigPart], style: &Style, config: &ImportConfig) -> Result<ImportedClip, ImportError> {
    let text = bvh(parts, style);
    interpret(reader::parse(text.as_bytes(), Path::new("a.bvh")).unwrap(), config, &[])
}

/// Roles that are not as the table has them.
fn wrong(parts: &[RigPart], found: &ImportedClip) -> Vec<String> {
    let want = |role: Joint| parts.iter().find(|p| p.role == Some(role)).map_or("-", |p| p.name.as_str());
    let got = |role: Joint| found.roles.get(role).map_or("-", |j| found.clip.joints[j].name.as_str());
    let differs = |r: &Joint| want(*r) != got(*r);
    Joint::ALL.into_iter().filter(differs).map(|r| format!("{}: {} not {}", r.name(), got(r), want(r))).collect()
}

const STYLES: [Style; 9] = {
    let plain = Style {
        rest: Rest::TPose,
        order: "ZXY",
        scale: 100.0,
        heading: 0.0,
        z_up: false,
        moves: true,
        mirrored: false,
    };
    [
        plain,
        Style { moves: false, ..plain },
        Style { rest: Rest::APose, order: "XYZ", ..plain },
        Style { rest: Rest::AlongX, order: "YXZ", ..plain },
        Style { rest: Rest::AlongY, order: "ZYX", scale: 1.0, ..plain },
        Style { heading: FRAC_PI_2, ..plain },
        Style { heading: PI, scale: 39.37, ..plain },
        Style { z_up: true, heading: -FRAC_PI_2, ..plain },
        Style { z_up: true, rest: Rest::AlongX, scale: 1000.0, ..plain },
    ]
};

#[test]
fn every_convention_is_recognised_in_every_style() {
    let mut failures = Vec::new();
    for (name, table) in tables::RIGS.into_iter().chain(tables::DRAWN) {
        let parts = parse(table);
        let mut good = 0;
        for (s, style) in STYLES.iter().enumerate() {
            let bad = match import(&parts, style) {
                Ok(found) => wrong(&parts, &found),
                Err(e) => vec![e.to_string()],
            };
            good += usize::from(bad.is_empty());
            failures.extend(bad.into_iter().map(|b| format!("{name}, style {s}: {b}")));
        }
        let joints = parts.len();
        println!("{name:<20} {joints:>3} joints  {good} of {} styles right", STYLES.len());
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

mod random {
    use super::*;
    use proptest::prelude::*;

    /// A rig of random proportions and extra joints, under names that say nothing or much.
    fn table(
        spine: usize,
        necks: usize,
        clavicles: bool,
        toes: bool,
        hips: usize,
        fingers: usize,
        named: bool,
    ) -> String {
        let name = |plain: &str| {
            if named {
                plain.to_owned()
            } else {
                format!("J{:x}", plain.bytes().fold(7u32, |h, b| h.wrapping_mul(31) ^ u32::from(b)))
            }
        };
        let mut out = String::new();
        let mut add = |n: &str, parent: &str, place: &str| {
            let side = |text: &str| {
                if text == "-" {
                    text.to_owned()
                } else if text.contains('~') {
                    format!("{{{},{}}}", name(&text.replace('~', "Left")), name(&text.replace('~', "Right")))
                } else {
                    name(text)
                }
            };
            out += &format!("{};{};{place}\n", side(n), side(parent));
        };
        add("Hips", "-", "hips");
        let step = 0.35 / spine as f32;
        let mut last = "Hips".to_owned();
        for k in 0..spine {
            let this = format!("Spine{k}");
            let role = match k {
                _ if k + 1 == spine => ";upper_chest",
                0 => ";spine",
                _ => ";-",
            };
            add(&this, &last, &format!("0 {} 0{role}", if k == 0 { 0.08 } else { step }));
            last = this;
        }
        let chest = last.clone();
        for k in 0..necks {
            let this = format!("Neck{k}");
            add(
                &this,
                &last,
                &format!("0 {} 0;{}", if k == 0 { 0.16 } else { 0.04 }, if k == 0 { "neck" } else { "-" }),
            );
            last = this;
        }
        add("Head", &last, &format!("0 {} 0.01;head", if necks == 0 { 0.25 } else { 0.08 }));
        let mut arm = chest.clone();
        if clavicles {
            add("~Shoulder", &chest, "0.03 0.13 0;left_clavicle");
            arm = "~Shoulder".into();
        }
        add("~Arm", &arm, if clavicles { "0.15 0 0;left_upper_arm" } else { "0.18 0.12 0;left_upper_arm" });
        add("~ForeArm", "~Arm", "0.29 0 0;left_forearm");
        add("~Hand", "~ForeArm", "0.25 0 0;left_hand");
        for f in 0..fingers {
            let z = 0.02 * f as f32 - 0.03;
            add(&format!("~HandIndex{f}a"), "~Hand", &format!("0.08 0 {z};-"));
            add(&format!("~HandIndex{f}b"), &format!("~HandIndex{f}a"), "0.04 0 0;-");
        }
        let mut leg = "Hips".to_owned();
        for h in 0..hips {
            let this = format!("~HipHelper{h}");
            add(&this, &leg, "0.02 0 0;-");
            leg = this;
        }
        add("~UpLeg", &leg, &format!("{} -0.05 0;left_thigh", 0.1 - 0.02 * hips as f32));
        add("~Leg", "~UpLeg", "0 -0.42 0;left_shin");
        add("~Foot", "~Leg", "0 -0.41 0;left_foot");
        if toes {
            add("~ToeBase", "~Foot", "0 -0.06 0.13;left_toe");
        }
        out
    }

    /// Joints of limbs as programs and games name them: thigh, shin, foot, clavicle, upper arm, forearm, hand; `~` is the side.
    const NAMES: [[&str; 7]; 4] = [
        ["UpperLeg.~", "LowerLeg.~", "Foot.~", "Shoulder.~", "UpperArm.~", "LowerArm.~", "Hand.~"],
        ["thigh_~", "calf_~", "foot_~", "clavicle_~", "upperarm_~", "lowerarm_~", "hand_~"],
        ["~ Thigh", "~ Shin", "~ Ankle", "~ Collar", "~ Upper Arm", "~ Elbow", "~ Wrist"],
        ["Oberschenkel_~", "Unterschenkel_~", "Fuß_~", "Schlüsselbein_~", "Oberarm_~", "Unterarm_~", "Hand_~"],
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// Names that say it decide, whatever the proportions.
        #[test]
        fn limbs_of_any_proportions_are_read_by_clear_names(
            names in 0usize..4,
            (thigh, shin, clavicle) in (0.2f32..0.48, 0.2f32..0.48, 0.03f32..0.35),
            (upper, fore, fingers) in (0.18f32..0.4, 0.13f32..0.4, 0.0f32..0.3),
            (rest, moves) in (0usize..4, any::<bool>()),
        ) {
            // Hanging arms do not come within a quarter of the leg from the ground, as forelegs do: shoulders are 0.5 m above thighs.
            prop_assume!(upper + fore + fingers < 0.75 * (thigh + shin) + 0.45);
            let side = |name: &str| name.replace('~', "{l,r}");
            let [t, s, f, c, u, e, h] = NAMES[names].map(side);
            let mut table = format!(
                "Hips;-;0 0.9 0;hips\nSpine;Hips;0 0.1 0;spine\nChest;Spine;0 0.25 0;upper_chest\n\
                 Neck;Chest;0 0.2 0;neck\nHead;Neck;0 0.1 0;head\n{c};Chest;0.02 0.12 0;left_clavicle\n\
                 {u};{c};{clavicle} 0 0;left_upper_arm\n{e};{u};{upper} 0 0;left_forearm\n{h};{e};{fore} 0 0;left_hand\n\
                 {t};Hips;0.1 -0.03 0;left_thigh\n{s};{t};0 -{thigh} 0;left_shin\n{f};{s};0 -{shin} 0;left_foot\n"
            );
            if fingers > 0.05 {
                table += &format!("Grip{{l,r}};{h};{fingers} 0 0;-\n");
            }
            let parts = parse(&table);
            let rest = [Rest::TPose, Rest::APose, Rest::AlongX, Rest::AlongY][rest];
            match import(&parts, &Style { rest, moves, ..Style::default() }) {
                Ok(found) => {
                    let wrong: Vec<String> =
                        wrong(&parts, &found).into_iter().filter(|w| !w.contains("toe")).collect();
                    prop_assert!(wrong.is_empty(), "{wrong:?} {table}");
                }
                Err(e) => prop_assert!(false, "{e}"),
            }
        }

        #[test]
        fn random_rigs_have_their_roles_right(
            (spine, necks, hips, fingers) in (1usize..=6, 0usize..=3, 0usize..=2, 0usize..=3),
            (clavicles, toes, named) in any::<(bool, bool, bool)>(),
            (rest, order) in (0usize..4, 0usize..4),
            (scale, heading, z_up) in (0.5f32..200.0, -PI..PI, any::<bool>()),
            noise in prop::collection::vec(-0.02f32..0.02, 64),
        ) {
            let mut parts = parse(&table(spine, necks, clavicles, toes, hips, fingers, named));
            // Everybody is a little asymmetric.
            for (p, n) in parts.iter_mut().zip(noise.iter().cycle()) {
                p.at *= 1.0 + 0.4 * n;
            }
            let rest = [Rest::TPose, Rest::APose, Rest::AlongX, Rest::AlongY][rest];
            let order = ["ZXY", "XYZ", "YXZ", "ZYX"][order];
            let style = Style { rest, order, scale, heading, z_up, ..Style::default() };
            match import(&parts, &style) {
                Ok(found) => {
                    let wrong: Vec<String> =
                        wrong(&parts, &found).into_iter().filter(|w| !w.starts_with("chest:")).collect();
                    prop_assert!(wrong.is_empty(), "{wrong:?}");
                    prop_assert!(spine < 3 || found.roles.get(Joint::Chest).is_some());
                }
                // Only the unit may be in doubt.
                Err(e) => prop_assert!(e.to_string().contains("metres_per_unit"), "{e}"),
            }
        }
    }
}
