"""The constant-volume burn

The paper integrates no reaction rate. Its gas burns as it is compressed, by the method of C. L. Mader, which "guarantees a
correct prediction of the speed of propagation and of the state of chemical equilibrium at all resolutions of the mesh".
"""

from pages import Page, record, show
from tubes import front_speed, gas_component, gas_tube

LENGTH = 1.52
# Law -> text, and our speeds over the Chapman-Jouguet speed by step over cell length [s/m] and number of cells.
LAWS = {
    "constant_volume": ("pressure is overwritten", {5e-5: ("1.40", "1.40"), 1e-4: ("1.20", "1.20"), 1.25e-4: ("1.12", "1.12")}),
    "pressure_burn": ("energy is conserved", {5e-5: ("0.999", "0.999"), 1e-4: ("0.998", "0.999"), 1.25e-4: ("0.997", "0.998")}),
}


def main(page: Page) -> None:
    """Run both burns on two meshes, at three steps given as fractions of the front's time to cross a cell."""
    for law, (words, known) in LAWS.items():
        page.add_heading(f"Speed of the front over the Chapman-Jouguet speed: {words}")
        for ratio, expected in known.items():
            for cells, found in zip((380, 760), expected, strict=True):
                document = gas_tube(1e5, cells=cells, length=LENGTH, reaction=law)
                document["component"]["step_size"] = ratio * LENGTH / cells
                speed = gas_component(document).front.speed
                what = f"cells of {1e3 * LENGTH / cells:.0f} mm, D h / dx = {speed * ratio:.2f}"
                ours = front_speed(record(document)) / speed
                page.compare(what, "correct", ours, near=1.0, within=0.01, reading="within 1 %", found=found)
    page.text("""The tube is closed, 1.52 m long, and filled with 100 kPa. D h / dx is the number of cells that a
        Chapman-Jouguet front crosses in a step h. The method overwrites the pressure of the flow, which does not conserve
        energy. Its front advances by one cell in six steps, two in seven, or one in three. Its speed depends on D h / dx and
        not on the mesh, so a finer mesh does not bring it closer to the Chapman-Jouguet speed. The other scripts use a burn
        that starts where the pressure has risen and that conserves energy.""")


if __name__ == "__main__":
    show(main)
