//! Legend of a colour map.

use crate::panels::words::number;
use eframe::egui::epaint::Mesh;
use eframe::egui::{Color32, Pos2, Rect, Sense, Shape, Ui};

/// A bar that runs through colours, with the numbers at its ends. Goes into a row of widgets.
pub fn legend(ui: &mut Ui, [low, high]: [f32; 2], what: &str, colour: impl Fn(f32) -> Color32) {
    ui.label(format!("{what} {}", number(low)));
    let (rect, _) = ui.allocate_exact_size([70.0, 10.0].into(), Sense::hover());
    ui.painter().add(Shape::mesh(bar(rect, colour)));
    ui.label(number(high));
}

fn bar(rect: Rect, colour: impl Fn(f32) -> Color32) -> Mesh {
    const PARTS: usize = 18;
    let mut mesh = Mesh::default();
    for i in 0..=PARTS {
        let t = i as f32 / PARTS as f32;
        let x = rect.left() + rect.width() * t;
        mesh.colored_vertex(Pos2::new(x, rect.top()), colour(t));
        mesh.colored_vertex(Pos2::new(x, rect.bottom()), colour(t));
        if i > 0 {
            let k = 2 * i as u32;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k, k + 1);
        }
    }
    mesh
}
