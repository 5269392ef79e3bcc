//! Figures of an instance of a patch, and its disabled links as a list.

use crate::command::{Commands, ViewerCommand, WorldCommand};
use crate::panels::paint::{self, RowClick, RowTable, TableCell, TableColumn};
use crate::panels::{colour_of_view, moment};
use crate::stage::world::{DISABLED, ENABLED};
use crate::{document::WorldDocument, model::Model};
use eframe::egui::{CollapsingHeader, Ui, vec2};
use throng_core::patch::CellRecord;
use throng_precompute::stitch::{InstanceItem, RemovalReason};

/// Columns of the list of disabled links.
const COLUMNS: [TableColumn<'static>; 4] = [
    TableColumn::number("link", "Number within the patch", 44.0),
    TableColumn::text("clip and time", "Motion it plays", 110.0, 1.0),
    TableColumn::number("frames", "Frames it plays", 48.0),
    TableColumn::text("taken out", "In a word; click for the whole reason", 120.0, 1.0),
];
/// Height of the list (points).
const HEIGHT: f32 = 170.0;

/// Figures of an instance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstanceFacts {
    /// Number of the instance.
    pub instance: u32,
    /// Cells that are left, and all.
    pub cells: [usize; 2],
    /// Entries that are left, and all.
    pub entries: [usize; 2],
    /// Exits that are left, and all.
    pub exits: [usize; 2],
    /// Enabled rest cells, and all.
    pub rests: [usize; 2],
    /// Why each link is disabled; none for an enabled link.
    pub links: Vec<Option<RemovalReason>>,
    /// Instances that it has joints with.
    pub neighbours: usize,
}

impl InstanceFacts {
    /// Counts cells and links of an instance (instance < number of instances).
    pub fn count_cells(world: &WorldDocument, instance: u32) -> Self {
        let graph = world.graph();
        let neighbours = graph.instance(instance).num_adjacencies as usize;
        let mut facts = Self { instance, neighbours, ..Self::default() };
        for (c, cell) in graph.cells(instance).iter().enumerate() {
            let left = usize::from(world.reason(instance, InstanceItem::Cell(c as u32)).is_none());
            let count = |is_one: bool, counts: &mut [usize; 2]| {
                if is_one {
                    (counts[0], counts[1]) = (counts[0] + left, counts[1] + 1);
                }
            };
            count(true, &mut facts.cells);
            count(cell.has_flags(CellRecord::IS_ENTRY), &mut facts.entries);
            count(cell.has_flags(CellRecord::IS_EXIT), &mut facts.exits);
            count(cell.has_flags(CellRecord::IS_REST), &mut facts.rests);
        }
        let links = 0..graph.links(instance).len() as u32;
        facts.links = links.map(|l| world.reason(instance, InstanceItem::Link(l))).collect();
        facts
    }

    /// Number of links disabled for a reason.
    pub fn num_taken_out(&self, reason: RemovalReason) -> usize {
        self.links.iter().filter(|l| **l == Some(reason)).count()
    }
}

/// A reason in plain words.
pub fn reason_text(reason: RemovalReason) -> &'static str {
    match reason {
        RemovalReason::NoNeighbour => "no tile across the edge",
        RemovalReason::Obstacle => "a unit is in the way",
        RemovalReason::DeadEnd => "leads nowhere",
        RemovalReason::OutsideComponent => "not reached from the rest",
    }
}

/// Shows the figures of an instance.
pub fn show(ui: &mut Ui, model: &Model, world: &WorldDocument, facts: &InstanceFacts, commands: &mut Commands) {
    let instance = facts.instance;
    ui.horizontal_wrapped(|ui| {
        ui.strong(format!("Patch {}", world.patch_name(instance)));
        ui.weak(format!("instance {instance}, {}", if world.graph().is_tile(instance) { "tile" } else { "block" }));
    });
    choose(ui, model, world, instance, commands);
    let of = |[left, all]: [usize; 2]| format!("{left} of {all} left");
    paint::facts(ui, "facts", true, |row| {
        let mut row = |name: &str, value: String| row(name, "", value.into());
        let units: Vec<String> = world.graph().resources(instance).iter().map(|&u| unit(world, u)).collect();
        row("units", units.join(", "));
        row("cells", of(facts.cells));
        if facts.entries[1] + facts.exits[1] > 0 {
            row("entries", of(facts.entries));
            row("exits", of(facts.exits));
        }
        row("places to stay", of(facts.rests));
        row("links", of([facts.links.iter().filter(|l| l.is_none()).count(), facts.links.len()]));
        row("overlaps", format!("{} others", facts.neighbours));
    });
    for reason in RemovalReason::ALL.into_iter().filter(|&r| facts.num_taken_out(r) > 0) {
        ui.label(format!("{} taken out: {}", facts.num_taken_out(reason), reason_text(reason)));
    }
    let mut shown = !model.selection.world.hides_links;
    ui.horizontal_wrapped(|ui| {
        if ui.checkbox(&mut shown, "Draw links:").changed() {
            commands.push(ViewerCommand::World(WorldCommand::ShowLinks(shown)));
        }
        for (colour, name) in [(ENABLED, "left"), (DISABLED, "taken out")] {
            ui.colored_label(colour_of_view(colour), "■");
            ui.label(name);
        }
    });
}

/// Name and number of a placed unit.
pub fn unit(world: &WorldDocument, place: u32) -> String {
    let name = world.placed().get(place as usize).map_or("unit", |p| &world.unit(p.unit).name);
    format!("{name} {place}")
}

/// One of the instances that the selected unit is part of.
fn choose(ui: &mut Ui, model: &Model, world: &WorldDocument, instance: u32, commands: &mut Commands) {
    let Some(place) = model.selection.world.place else { return };
    let all = world.instances_of(place);
    if all.len() < 2 {
        return;
    }
    let name = |i: u32| format!("{} ({i})", world.patch_name(i));
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("The unit is in {} patches:", all.len()));
        let mut chosen = instance;
        paint::choose(ui, "Patch", None, &mut chosen, all.into_iter().map(|i| (i, name(i))));
        let select = (chosen != instance).then_some(WorldCommand::SelectInstance(Some(chosen)));
        commands.extend(select.map(ViewerCommand::World));
    });
}

/// Shows the list of disabled links; a click selects one.
pub fn show_links(ui: &mut Ui, model: &Model, world: &WorldDocument, facts: &InstanceFacts, commands: &mut Commands) {
    let (graph, selected) = (world.graph(), model.selection.world.link);
    let out: Vec<usize> = (0..facts.links.len()).filter(|&l| facts.links[l].is_some()).collect();
    if out.is_empty() {
        return;
    }
    CollapsingHeader::new(format!("{} links taken out", out.len())).default_open(true).show(ui, |ui| {
        let size = vec2(ui.available_width(), HEIGHT);
        ui.allocate_ui(size, |ui| {
            ui.set_min_size(size);
            let table = RowTable {
                click: RowClick::Does("Show"),
                selected: selected.and_then(|s| out.iter().position(|&l| l == s as usize)),
                ..RowTable::new("links taken out", &COLUMNS, out.len())
            };
            let response = table.show(ui, |row, column| {
                let (number, link) = (out[row], &graph.links(facts.instance)[out[row]]);
                match column {
                    0 => TableCell::new(number.to_string()),
                    1 => TableCell::new(moment(world.bundle(), link.frame)).ending(),
                    2 => TableCell::new(link.num_frames.to_string()),
                    _ => TableCell::new(facts.links[number].map_or("", reason_text)),
                }
            });
            let link = response.chosen.map(|row| WorldCommand::SelectLink(Some(out[row] as u32)));
            commands.extend(link.map(ViewerCommand::World));
        });
    });
}
