"""
Contact laws
============

The same damper with an elastic obstacle, a soft stop, and an obstacle with a coefficient of
restitution of 0.7.  Stiffer contacts hardly differ; what a contact loses does.
"""

import matplotlib.pyplot as plt

import nlds_vines as nv

laws = {
    "Hertz's law": {},
    "spring and dashpot": {"law": "linear", "kc": 1e6, "cc": 1000.0},
    "restitution, e = 0.7": {"law": "restitution", "e": 0.7},
}
figure, axes = plt.subplots(figsize=(6.3, 3.6), layout="constrained")
for (name, contact), color in zip(laws.items(), ("#0072b2", "#d55e00", "#009e73"), strict=True):
    system = nv.load_system("ssul-set6", **contact)
    scan = nv.load_scan(
        {
            "system": system,
            "vary": {"omega": {"start": 5.0, "stop": 7.3, "num": 101}},
            "sampling": {"transient": 400, "periods": 60},
            "record": {"want": ["energy"]},
        }
    )
    with nv.scan(scan).read() as archive:
        axes.plot(archive["omega"], archive["E1max"][:, 0], color=color, label=name)
axes.set_xlabel(r"angular frequency of the force $\omega$ [rad/s]")
axes.set_ylabel(r"energy of the structure $E_1^\mathrm{max}$ [J]")
axes.set(xlim=(5, 7.3), ylim=(0, None))
axes.legend(frameon=False)
plt.show()
