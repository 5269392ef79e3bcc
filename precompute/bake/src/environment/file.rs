//! Environment files: units and groups of them, placed once or in regular patterns.

use super::{Environment, PlacedUnit, UnitSet};
use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use throng_base::text;
use throng_core::patch::Placement;
use throng_motion::error::{BuildError, Result};

/// Most units of an environment.
const MAX_UNITS: usize = 1_000_000;

/// Deepest nesting of prefabs.
const MAX_DEPTH: usize = 64;

/// Upper bound of positions and headings (m, deg).
const MAX_NUMBER: f32 = 1e5;

/// Contents of an environment file; world files use the same keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentFile {
    /// Name; the file's stem if absent.
    pub name: String,
    /// File of unit objects, relative to this file's folder.
    pub units: PathBuf,
    /// Groups of units that are placed together, by name; may hold other groups.
    pub prefabs: BTreeMap<String, Vec<PlacementPattern>>,
    /// Placed units and prefabs.
    pub place: Vec<PlacementPattern>,
}

/// A unit or prefab, placed once or in a regular pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacementPattern {
    /// Name of a unit or a prefab.
    pub unit: String,
    /// Position of the origin: x, y, z (m).
    pub at: [f32; 3],
    /// Angle about the vertical, counted from +Z to +X (deg).
    #[serde(default)]
    pub heading_deg: f32,
    /// Number of copies along `step[0]`, `step[1]` and `step[2]`, in the frame of the file or prefab (>= 1 each).
    #[serde(default = "single_count")]
    pub repeat: [u32; 3],
    /// Offset between copies, for each number of `repeat`: x, y, z (m).
    #[serde(default)]
    pub step: [[f32; 3]; 3],
}

fn single_count() -> [u32; 3] {
    [1; 3]
}

impl EnvironmentFile {
    /// Reads an environment file; `units` is relative to its folder.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::Config`] with file, line and column.
    pub fn load(path: &Path) -> Result<Self> {
        let source = text::TomlSource::read(path, "an environment")?;
        let mut file: Self = source.parse("An environment has `units`, `place` and `prefabs`.")?;
        if file.name.is_empty() {
            file.name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        }
        if file.units.as_os_str().is_empty() {
            return Err(
                BuildError::key("units", "expected a file of unit objects, found nothing").with_position(&source)
            );
        }
        file.units = path.parent().unwrap_or(Path::new("")).join(&file.units);
        Ok(file)
    }

    /// Resolves patterns and prefabs into placed units; headings add up.
    ///
    /// - `path`: of the file, which is read again to locate an error.
    /// - returns the units in the order of the file, the last number of `repeat` varying fastest.
    ///
    /// # Errors
    /// [`BuildError::File`] with file, place and key for a name that is no unit or prefab (with the nearest one), for a
    /// prefab that holds itself or too many others, for numbers that are not finite, and for two equal units in one place.
    pub fn expand(&self, units: &UnitSet, path: &Path) -> Result<Environment> {
        self.lay_out(units).map_err(|e| e.in_file(path))
    }

    fn lay_out(&self, units: &UnitSet) -> Result<Environment> {
        let numbers: HashMap<&str, usize> = units.units.iter().enumerate().map(|(i, u)| (u.name.as_str(), i)).collect();
        if let Some(name) = self.prefabs.keys().find(|name| numbers.contains_key(name.as_str())) {
            let why = "a unit has that name too; rename one of them";
            return Err(BuildError::key(format!("prefabs.{name}"), why));
        }
        let (open, out, taken) = (Vec::new(), Vec::new(), BTreeSet::new());
        let mut layout = EnvironmentLayout { file: self, units, numbers, open, out, taken };
        // Prefabs that are never placed must be valid too.
        for (name, places) in &self.prefabs {
            if places.is_empty() {
                return Err(BuildError::key(format!("prefabs.{name}"), "expected at least one unit, found none"));
            }
            layout.open.push(name);
            places.iter().enumerate().try_for_each(|(i, place)| layout.check(place, i))?;
            layout.open.pop();
        }
        layout.place_all(&self.place, Placement::IDENTITY)?;
        Ok(Environment { name: self.name.clone(), units: layout.out })
    }
}

/// State while units are laid out.
struct EnvironmentLayout<'a> {
    file: &'a EnvironmentFile,
    units: &'a UnitSet,
    /// Number of each unit, by name.
    numbers: HashMap<&'a str, usize>,
    /// Prefabs being expanded, outermost first.
    open: Vec<&'a str>,
    out: Vec<PlacedUnit>,
    /// Occupied places: unit, position and heading in thousandths of a metre and a degree.
    taken: BTreeSet<(usize, [i64; 4])>,
}

impl<'a> EnvironmentLayout<'a> {
    fn fault<T>(&self, index: usize, key: &str, what: String) -> Result<T> {
        let list = self.open.last().map_or("place".to_owned(), |name| format!("prefabs.{name}"));
        let list = format!("{list}[{index}]");
        Err(BuildError::key(key, what).within_key(&list))
    }

    fn check(&self, place: &PlacementPattern, index: usize) -> Result<()> {
        self.check_magnitude(index, "at", &place.at)?;
        self.check_magnitude(index, "heading_deg", &[place.heading_deg])?;
        self.check_magnitude(index, "step", place.step.as_flattened())?;
        if place.repeat.contains(&0) {
            return self.fault(index, "repeat", format!("expected numbers of at least 1, found {:?}", place.repeat));
        }
        let name = place.unit.as_str();
        if !self.numbers.contains_key(name) && !self.file.prefabs.contains_key(name) {
            let known = self.units.units.iter().map(|u| u.name.as_str());
            let known = known.chain(self.file.prefabs.keys().map(String::as_str));
            let meant = text::did_you_mean(name, known);
            let place = self.file.units.display();
            return self.fault(index, "unit", format!("no unit of {place} and no prefab is called `{name}`.{meant}"));
        }
        Ok(())
    }

    fn check_magnitude(&self, index: usize, key: &str, numbers: &[f32]) -> Result<()> {
        match numbers.iter().all(|v| v.abs() < MAX_NUMBER) {
            true => Ok(()),
            false => self.fault(index, key, format!("expected numbers below {MAX_NUMBER}, found {numbers:?}")),
        }
    }

    fn place_all(&mut self, places: &'a [PlacementPattern], frame: Placement) -> Result<()> {
        for (index, place) in places.iter().enumerate() {
            self.check(place, index)?;
            let count = place.repeat.iter().fold(1usize, |n, &r| n.saturating_mul(r as usize));
            if count.saturating_add(self.out.len()) > MAX_UNITS {
                return self.fault(index, "repeat", format!("an environment may hold {MAX_UNITS} units, found more"));
            }
            let heading = place.heading_deg.to_radians();
            let at = Vec3::from(place.at);
            let steps = place.step.map(Vec3::from);
            for i in 0..place.repeat[0] {
                for j in 0..place.repeat[1] {
                    for k in 0..place.repeat[2] {
                        let p = at + steps[0] * i as f32 + steps[1] * j as f32 + steps[2] * k as f32;
                        let here = frame.compose(Placement::new(p.x, p.y, p.z, heading));
                        self.place_one(place, index, here)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn place_one(&mut self, place: &'a PlacementPattern, index: usize, at: Placement) -> Result<()> {
        if let Some(&unit) = self.numbers.get(place.unit.as_str()) {
            let placement = at.with_wrapped_heading();
            let Placement { x, y, z, .. } = placement;
            self.check_magnitude(index, if place.repeat == single_count() { "at" } else { "step" }, &[x, y, z])?;
            if self.out.len() >= MAX_UNITS {
                return self.fault(index, "", format!("an environment may hold {MAX_UNITS} units, found more"));
            }
            let thousandths = |v: f32| (f64::from(v) * 1000.0).round() as i64;
            let turn = 360.0 / self.units.units[unit].symmetry as f32;
            let heading = placement.heading.to_degrees().rem_euclid(turn);
            let heading = if turn - heading < 5e-4 { 0.0 } else { heading };
            let key = [placement.x, placement.y, placement.z, heading].map(thousandths);
            if !self.taken.insert((unit, key)) {
                let what = format!("`{}` stands at ({x:.3}, {y:.3}, {z:.3}) twice; leave one out", place.unit);
                return self.fault(index, "", what);
            }
            self.out.push(PlacedUnit { unit, placement });
            return Ok(());
        }
        let (name, places) = self.file.prefabs.get_key_value(&place.unit).expect("`check` found it");
        if self.open.contains(&name.as_str()) {
            let chain = [&self.open[..], &[name.as_str()]].concat().join("` holds `");
            return self.fault(index, "unit", format!("`{chain}`: a prefab cannot hold itself"));
        }
        if self.open.len() == MAX_DEPTH {
            let why = format!(
                "`{name}` would be level {} of prefabs in each other, expected {MAX_DEPTH} at most",
                MAX_DEPTH + 1
            );
            return self.fault(index, "unit", why);
        }
        self.open.push(name);
        self.place_all(places, at)?;
        self.open.pop();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn units() -> UnitSet {
        let text = "[[units]]\nname = \"post\"\nshapes = [{ bar = { from = [0.0, 0.0, 0.0], to = [0.0, 2.0, 0.0], \
                    radius = 0.04 } }]\n[[units]]\nname = \"panel\"\nsymmetry = 4\nfloor = true\n";
        UnitSet::parse(text, Path::new("units.toml")).unwrap()
    }

    fn expand(text: &str) -> Result<Environment, String> {
        let file: EnvironmentFile = toml::from_str(text).unwrap();
        file.expand(&units(), Path::new("e.toml")).map_err(|e| e.to_string())
    }

    #[test]
    fn patterns_run_through_their_numbers_and_prefabs_turn_what_they_hold() {
        let e = expand(
            "units = \"u.toml\"\nplace = [{ unit = \"row\", at = [10.0, 1.0, 0.0], heading_deg = 90.0 },\n\
             { unit = \"panel\", at = [0.0, 0.0, 0.0], repeat = [2, 1, 3], step = [[2.0, 0.0, 0.0], [0.0, 0.0, 0.0], \
             [0.0, 0.0, 3.0]] }]\n[prefabs]\nrow = [{ unit = \"pair\", at = [0.0, 0.0, 1.0], heading_deg = 90.0 }]\n\
             pair = [{ unit = \"post\", at = [0.0, 0.5, 0.0] }, { unit = \"post\", at = [0.0, 0.0, 2.0] }]\n",
        )
        .unwrap();
        let near = |i: usize, want: [f32; 4]| {
            let p = e.units[i].placement;
            let found = [p.x, p.y, p.z, p.heading];
            let off = found.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off < 1e-5, "{i}: {found:?}");
        };
        assert_eq!(e.units.iter().map(|u| u.unit).collect::<Vec<_>>(), [0, 0, 1, 1, 1, 1, 1, 1]);
        // 1 m ahead of a row that faces +X lies at x = 11; the second turn by 90 degrees makes "ahead" -Z.
        near(0, [11.0, 1.5, 0.0, PI]);
        near(1, [11.0, 1.0, -2.0, PI]);
        near(3, [0.0, 0.0, 3.0, 0.0]);
        near(7, [2.0, 0.0, 6.0, 0.0]);
    }

    #[test]
    fn a_prefab_that_holds_itself_is_refused_by_name() {
        let e = expand(
            "units = \"u.toml\"\nplace = [{ unit = \"a\", at = [0.0, 0.0, 0.0] }]\n[prefabs]\n\
             a = [{ unit = \"b\", at = [0.0, 0.0, 0.0] }]\nb = [{ unit = \"a\", at = [0.0, 0.0, 0.0] }]\n",
        )
        .unwrap_err();
        assert_eq!(e, "e.toml: prefabs.b[0].unit: `a` holds `b` holds `a`: a prefab cannot hold itself");
    }

    #[test]
    fn a_long_chain_of_prefabs_is_refused_and_a_short_one_is_laid_out() {
        let chain = |n: usize| {
            let held = |i: usize| if i + 1 < n { format!("p{}", i + 1) } else { "post".into() };
            let link = |i: usize| format!("p{i} = [{{ unit = \"{}\", at = [0.0, 0.0, 0.0] }}]\n", held(i));
            let links: String = (0..n).map(link).collect();
            expand(&format!(
                "units = \"u.toml\"\nplace = [{{ unit = \"p0\", at = [0.0, 0.0, 0.0] }}]\n[prefabs]\n{links}"
            ))
        };
        assert_eq!(chain(64).unwrap().units.len(), 1);
        for n in [65, 20_000] {
            let e = chain(n).unwrap_err();
            let key = "e.toml: prefabs.p63[0].unit";
            assert_eq!(e, format!("{key}: `p64` would be level 65 of prefabs in each other, expected 64 at most"));
        }
    }

    #[test]
    fn faults_of_a_file_name_line_and_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("e.toml");
        let text = "units = \"u.toml\"\n[[place]]\nunit = \"row\"\nat = [0, 0, 0]\n\n[[prefabs.row]]\n\
                    unit = \"post\"\nat = [0, 1e7, 0]\n";
        std::fs::write(&path, text).unwrap();
        let e = EnvironmentFile::load(&path).unwrap().expand(&units(), &path).unwrap_err().to_string();
        assert!(e.contains("e.toml:8:1: prefabs.row[0].at: expected numbers below 100000"), "{e}");
    }

    #[test]
    fn faults_name_file_and_key() {
        let place = |s: &str| expand(&format!("units = \"u.toml\"\nplace = [{s}]\n")).unwrap_err();
        let e = place("{ unit = \"pots\", at = [0.0, 0.0, 0.0] }");
        assert!(e.starts_with("e.toml: place[0].unit: no unit of u.toml"), "{e}");
        assert!(e.ends_with("is called `pots`. Did you mean `post`?"), "{e}");
        let e = place("{ unit = \"post\", at = [nan, 0.0, 0.0] }");
        assert!(e.starts_with("e.toml: place[0].at: expected numbers below"), "{e}");
        let e = place(
            "{ unit = \"post\", at = [0.0, 0.0, 0.0], repeat = [2, 1, 1], step = [[9e4, 0, 0], [0, 0, 0], [0, 0, 0]] }, \
             { unit = \"post\", at = [0.0, 0.0, 5.0], repeat = [3, 1, 1], step = [[9e4, 0, 1], [0, 0, 0], [0, 0, 0]] }",
        );
        assert_eq!(e, "e.toml: place[1].step: expected numbers below 100000, found [180000.0, 0.0, 7.0]");
        let e = place("{ unit = \"post\", at = [0.0, 0.0, 0.0], repeat = [1, 0, 1] }");
        assert!(e.starts_with("e.toml: place[0].repeat: expected numbers of at least 1"), "{e}");
        let e = place("{ unit = \"post\", at = [0.0, 0.0, 0.0], repeat = [9999, 9999, 9999] }");
        assert!(e.contains("place[0].repeat: an environment may hold 1000000 units"), "{e}");
        let e = place("{ unit = \"post\", at = [1.0, 0.0, 0.0], repeat = [2, 1, 1] }");
        assert_eq!(e, "e.toml: place[0]: `post` stands at (1.000, 0.000, 0.000) twice; leave one out");
        let same = "{ unit = \"panel\", at = [1.0, 0.0, 0.0] }, { unit = \"panel\", at = [1.0, 0.0, 0.0], \
                    heading_deg = -90.0 }";
        assert!(place(same).contains("place[1]: `panel` stands at"), "a quarter turn changes nothing");
        let unused = "units = \"u.toml\"\n[prefabs]\nnever = [{ unit = \"nothing\", at = [0.0, 0.0, 0.0] }]\n";
        assert!(expand(unused).unwrap_err().contains("prefabs.never[0].unit"));
        let both = "units = \"u.toml\"\n[prefabs]\npost = []\n";
        assert!(expand(both).unwrap_err().contains("prefabs.post: a unit has that name too"));
        let empty = "units = \"u.toml\"\n[prefabs]\nnothing = []\n";
        assert!(expand(empty).unwrap_err().contains("prefabs.nothing: expected at least one unit"));
    }

    #[test]
    fn a_file_is_read_from_its_folder_and_named_after_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("yard.toml");
        std::fs::write(&path, "units = \"things.toml\"\n").unwrap();
        let file = EnvironmentFile::load(&path).unwrap();
        assert_eq!((file.name.as_str(), file.units), ("yard", folder.path().join("things.toml")));
        std::fs::write(&path, "plaice = []\n").unwrap();
        let e = EnvironmentFile::load(&path).unwrap_err().to_string();
        assert!(e.contains("yard.toml:1:1: unknown field `plaice`") && e.contains("`place`?"), "{e}");
        std::fs::write(&path, "place = []\n").unwrap();
        let e = EnvironmentFile::load(&path).unwrap_err().to_string();
        assert!(e.contains("yard.toml:1:1: units: expected a file of unit objects"), "{e}");
    }
}
