"""The exitance as a function that PyTorch differentiates by κ, μ and irradiance."""
import numpy as np
import torch


class _Exitance(torch.autograd.Function):
    @staticmethod
    def forward(ctx, kappa, mu, irradiance, operator, face):
        # The operator keeps κ and μ: they must not change under it.
        arrays = [np.array(t.detach().cpu(), dtype=np.float64) for t in (kappa, mu, irradiance)]
        operator.set_medium(*arrays[:2])
        ctx.light, ctx.face, ctx.like = operator.illuminate(arrays[2]), face, (kappa, mu, irradiance)
        ctx.operator, ctx.medium = operator, arrays[:2]
        return torch.as_tensor(ctx.light.exitance(face), dtype=kappa.dtype, device=kappa.device)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx, by_exitance):
        weights = np.ascontiguousarray(by_exitance.detach().cpu().numpy(), dtype=np.float64)
        light = ctx.light
        if ctx.operator.medium_changed(light):
            # Another call has used the operator since: solve again.
            ctx.operator.set_medium(*ctx.medium)
            light = ctx.operator.illuminate(np.array(ctx.like[2].detach().cpu(), dtype=np.float64))
        found = light.gradient(weights, ctx.face)
        gradients = (torch.as_tensor(g.reshape(t.shape), dtype=t.dtype, device=t.device) for g, t in zip(found, ctx.like))
        return (*gradients, None, None)


def exitance(operator, kappa, mu, irradiance, face="z+"):
    """Exitance of `face`, [M][v][u], of tensors kappa [mm], mu [1/mm] [z][y][x] and irradiance [M][v][u].

    `operator` is a DiffusionOperator, whose medium is set by the call. The derivative is that of the discrete model, exact to
    the operator's tolerance. Second derivatives are not there. The tensors must not be changed in place before backward().
    """
    return _Exitance.apply(kappa, mu, irradiance, operator, face)
