"""`kappamu-studies sfdi`."""
from charts.common import COLOURS, MARKS, dress, flat, panels, provenance


def peer(record):
    """Errors of transport and of diffusion against another group's Monte Carlo, beside their cost."""
    rows = record["rows"]
    figure, (even, wave) = panels(2, 2, 5.6, 4.2)
    kinds = [("", "transport, this table"), (" diffusion", "diffusion"), (" other group", "another group's table")]
    costs = {"": record["nanoseconds"], " diffusion": record["nanoseconds_diffusion"]}
    for ax, name, title in ((even, "even", "even light"), (wave, "wave", "under a sinusoid")):
        for number, (end, label) in enumerate(kinds):
            known = [row for row in rows if name + end in row]
            if not known:
                continue
            cost = f", {costs[end]:.0f} ns" if end in costs else ""
            ax.plot([row["f_per_mm"] / row["musp_per_mm"] if name == "wave" else row["mua_per_mm"] / row["musp_per_mm"]
                     for row in known], [100 * row[name + end] for row in known], MARKS[number], color=COLOURS[number],
                    markerfacecolor="none", label=label + cost)
        dress(ax, title, "f / σs'" if name == "wave" else "μa / σs'", "reflectance's error [%]", "x" if name == "even" else "")
    text = provenance(record) + "\n" + flat(
        [{"reflectance by": "this table", "largest error up to 0.3 /mm": record["largest_up_to_0.3"],
          "cost with derivatives [ns]": round(record["nanoseconds"])},
         {"reflectance by": "diffusion", "largest error up to 0.3 /mm": record["largest_up_to_0.3_diffusion"],
          "cost with derivatives [ns]": round(record["nanoseconds_diffusion"])}],
        ["reflectance by", "largest error up to 0.3 /mm", "cost with derivatives [ns]"])
    return {"": figure}, {"": text}
