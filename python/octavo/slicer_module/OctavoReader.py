"""Opens .8vo files in 3D Slicer: drop one on it, or take File, Add Data.

Its folder belongs into the additional module paths of Slicer, the wheel of octavo into its Python.
"""

import slicer
from slicer.ScriptedLoadableModule import ScriptedLoadableModule


class OctavoReader(ScriptedLoadableModule):
    """The module, which has no panel of its own."""

    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        parent.title = "Octavo volumes"
        parent.categories = ["Informatics"]
        parent.hidden = True


class OctavoReaderFileReader:
    """What Slicer asks of files."""

    def __init__(self, parent):
        self.parent = parent

    def description(self):
        """In the dialog of Add Data."""
        return "Octavo volume"

    def fileType(self):
        """The name of the type among Slicer's."""
        return "OctavoVolume"

    def extensions(self):
        """What such files end in."""
        return ["Octavo volume (*.8vo)"]

    def canLoadFile(self, path):
        """Whether a file is one of them."""
        return path.lower().endswith(".8vo")

    def load(self, properties):
        """Makes a node of the file; its level and nbytes are as of octavo.slicer.node_of."""
        import octavo.slicer
        options = {name: properties[name] for name in ("level", "nbytes") if name in properties}
        try:
            made = octavo.slicer.node_of(properties["fileName"], **options)
        except octavo.Error as error:
            slicer.util.errorDisplay(str(error))
            return False
        node = slicer.util.addVolumeFromArray(**made)
        self.parent.loadedNodes = [node.GetID()]
        return True
