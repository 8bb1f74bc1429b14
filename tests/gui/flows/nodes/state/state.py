from grip_bt.nodes import Leaf


class State(Leaf):
    def update(self):
        return self.end("outcome2")
