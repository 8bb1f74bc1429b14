from grip_bt.nodes import Leaf


class Step(Leaf):
    def update(self):
        return self.end()
