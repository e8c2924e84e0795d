//! Plots as SVG: curves, and pictures with axes.

use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use niji_exchange::Provenance;
use plotters::prelude::*;

use crate::failure::Failure;
use crate::output;

/// Size of a plot in pixels.
const SIZE: (u32, u32) = (960, 600);
/// Lowest value on a logarithmic axis, relative to the largest.
const DECADES_SHOWN: f64 = 1e-6;
/// Colors that the color-blind can tell apart (Okabe and Ito 2008).
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// A plot of curves over one axis, the values on a logarithmic one.
pub(crate) struct Plot {
    pub(crate) title: String,
    pub(crate) x_label: &'static str,
    pub(crate) y_label: &'static str,
    pub(crate) curves: Vec<Curve>,
}

/// A picture between axes, the horizontal one logarithmic.
pub(crate) struct Picture<'a> {
    pub(crate) title: String,
    pub(crate) x_label: &'static str,
    pub(crate) y_label: &'static str,
    /// Values at the left and right edges.
    pub(crate) x_range: (f64, f64),
    /// Values at the lower and upper edges.
    pub(crate) y_range: (f64, f64),
    pub(crate) png: &'a [u8],
}

/// One curve with its name in the legend.
pub(crate) struct Curve {
    pub(crate) label: String,
    pub(crate) points: Vec<(f64, f64)>,
}

impl Plot {
    /// Writes the plot.
    ///
    /// # Errors
    /// No positive value to draw, or a file that cannot be written.
    pub(crate) fn write_svg(&self, path: &Path) -> Result<(), Failure> {
        output::write_text(path, &drawn(self.svg(), path)?)
    }

    fn svg(&self) -> Result<String, Box<dyn std::error::Error>> {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let left = points().map(|point| point.0).fold(f64::INFINITY, f64::min);
        let right = points()
            .map(|point| point.0)
            .fold(f64::NEG_INFINITY, f64::max);
        let top = points().map(|point| point.1).fold(0.0, f64::max);
        if !(top > 0.0 && right > left) {
            return Err("there is no light to draw in this range".into());
        }
        let positive = points().map(|point| point.1).filter(|value| *value > 0.0);
        let bottom = positive.fold(top, f64::min).max(DECADES_SHOWN * top);
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .caption(&self.title, ("sans-serif", 20))
                .margin(12)
                .x_label_area_size(44)
                .y_label_area_size(80)
                .build_cartesian_2d(left..right, (0.8 * bottom..1.3 * top).log_scale())?;
            chart
                .configure_mesh()
                .x_desc(self.x_label)
                .y_desc(self.y_label)
                .y_label_formatter(&|value| format!("{value:.0e}"))
                .light_line_style(RGBColor(236, 236, 236))
                .draw()?;
            for (curve, color) in self.curves.iter().zip(COLORS.iter().cycle()) {
                let shown = curve.points.iter().map(|&(x, y)| (x, y.max(0.8 * bottom)));
                chart
                    .draw_series(LineSeries::new(shown, color.stroke_width(2)))?
                    .label(curve.label.as_str())
                    .legend(|(x, y)| {
                        PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2))
                    });
            }
            chart
                .configure_series_labels()
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(200, 200, 200))
                .draw()?;
            area.present()?;
        }
        Ok(svg)
    }
}

/// Points of several kinds between two logarithmic axes, and a line along some of them.
pub(crate) struct Cloud {
    pub(crate) title: String,
    pub(crate) x_label: &'static str,
    pub(crate) y_label: &'static str,
    /// Points by the name of their kind.
    pub(crate) groups: Vec<(String, Vec<(f64, f64)>)>,
    /// The line, ascending.
    pub(crate) front: Vec<(f64, f64)>,
}

impl Cloud {
    /// The plot as SVG; points of height 0 stand on its lower edge.
    ///
    /// # Errors
    /// Nothing to draw.
    pub(crate) fn svg(&self) -> Result<String, Failure> {
        let drawn = self.drawn();
        drawn.map_err(|error| Failure::Failed(format!("cannot draw {}: {error}", self.title)))
    }

    fn drawn(&self) -> Result<String, Box<dyn std::error::Error>> {
        let points = || self.groups.iter().flat_map(|(_, points)| points);
        let (left, right) =
            span(points().map(|point| point.0)).ok_or("there is nothing to draw")?;
        let (bottom, top) = span(points().map(|point| point.1)).unwrap_or((0.1, 1.0));
        let floor = 0.5 * bottom;
        let place = |&(x, y): &(f64, f64)| (x, y.max(floor));
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            area.fill(&WHITE)?;
            let x_axis = (0.8 * left..1.25 * right).log_scale();
            let mut chart = ChartBuilder::on(&area)
                .caption(&self.title, ("sans-serif", 20))
                .margin(12)
                .x_label_area_size(44)
                .y_label_area_size(80)
                .build_cartesian_2d(x_axis, (0.8 * floor..1.5 * top).log_scale())?;
            chart
                .configure_mesh()
                .x_desc(self.x_label)
                .y_desc(self.y_label)
                .x_label_formatter(&|value| format!("{value:.2}"))
                .y_label_formatter(&|value| format!("{value:.0e}"))
                .light_line_style(RGBColor(236, 236, 236))
                .draw()?;
            let line = self.front.iter().map(place);
            chart
                .draw_series(LineSeries::new(line, BLACK.mix(0.5).stroke_width(1)))?
                .label("Pareto front")
                .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK.mix(0.5)));
            for (index, (name, points)) in self.groups.iter().enumerate() {
                let color = COLORS[index % COLORS.len()];
                // When colors come again, circles are open.
                let style = if index < COLORS.len() {
                    color.filled()
                } else {
                    color.stroke_width(2)
                };
                let circles = points
                    .iter()
                    .map(|point| Circle::new(place(point), 5, style));
                chart
                    .draw_series(circles)?
                    .label(name.as_str())
                    .legend(move |(x, y)| Circle::new((x + 9, y), 5, style));
            }
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(200, 200, 200))
                .draw()?;
            area.present()?;
        }
        Ok(svg)
    }
}

/// Smallest and largest of the positive values.
fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| *value > 0.0)
        .fold(None, |span, value| {
            let (low, high) = span.unwrap_or((value, value));
            Some((value.min(low), value.max(high)))
        })
}

impl Picture<'_> {
    /// Writes the picture with its axes; the pixels are inside the file.
    ///
    /// # Errors
    /// An empty axis, or a file that cannot be written.
    pub(crate) fn write_svg(&self, path: &Path, made_for: &Provenance) -> Result<(), Failure> {
        let svg = drawn(self.svg(), path)?;
        output::write_file_for(path, made_for, |to| to.write_all(svg.as_bytes()))
    }

    fn svg(&self) -> Result<String, Box<dyn std::error::Error>> {
        let mut svg = String::new();
        let (x_pixels, y_pixels) = {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            let (left, right) = self.x_range;
            let mut chart = ChartBuilder::on(&area)
                .caption(&self.title, ("sans-serif", 20))
                .margin(12)
                .x_label_area_size(44)
                .y_label_area_size(60)
                .build_cartesian_2d((left..right).log_scale(), self.y_range.0..self.y_range.1)?;
            chart
                .configure_mesh()
                .disable_mesh()
                .x_desc(self.x_label)
                .y_desc(self.y_label)
                .draw()?;
            area.present()?;
            chart.plotting_area().get_pixel_range()
        };
        let image = format!(
            "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
             href=\"data:image/png;base64,{}\"/>\n</svg>",
            x_pixels.start,
            y_pixels.start,
            x_pixels.end - x_pixels.start,
            y_pixels.end - y_pixels.start,
            BASE64_STANDARD.encode(self.png)
        );
        Ok(svg.replace("</svg>", &image))
    }
}

fn drawn(svg: Result<String, Box<dyn std::error::Error>>, path: &Path) -> Result<String, Failure> {
    svg.map_err(|error| Failure::Failed(format!("cannot draw {}: {error}", path.display())))
}
